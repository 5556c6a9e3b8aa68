"""The model of an arm: fitted to recordings, shown, saved, and used on other recordings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ur5lib import __version__
from ur5lib.chain.predicted import beside_measured, errors, expect_predicted, friction_at
from ur5lib.chain.recordings import Recordings, as_recordings, forces_of
from ur5lib.chain.shown import Shown, bar, counted, frames
from ur5lib.chain.steps import Chain, Files
from ur5lib.errors import InputError, expect_known, expect_text, some
from ur5lib.jobs.files import parameter_types
from ur5lib.jobs.job import step_named
from ur5lib.jobs.memory import Contents, call, record_of, text_of
from ur5lib.records.friction import Friction
from ur5lib.records.premises import Premises
from ur5lib.records.units import column_units
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import PARAMETER_UNITS
from ur5lib.study.model import Settings, Study
from ur5lib.study.selection import Selection
from ur5lib.tables import as_written, write_text

if TYPE_CHECKING:  # it loads for a while, and only a figure needs it
    from matplotlib.figure import Figure

TABLES = ["friction", "torque_constants", "cross_validation", "rotor_inertia", "parameters"]
TABLES += ["excitation", "remarks"]
FILES_OF_TABLES = {
    "identified": "arm",
    "rotors": "rotors",
    "identification": "summary",
    "friction": "friction",
    "residuals": "residuals",
}
OF_JOINTS = ("friction", "current_torque", "current_torque_friction")  # with a panel per joint
OF_FRICTION = (*OF_JOINTS, "residuals", "knowledge")
OF_MODELS = ("models", "frames")
FIGURES = dict.fromkeys(OF_FRICTION, "draw_friction") | dict.fromkeys(OF_MODELS, "draw_models")
YAML_FILES = ("described", "arm", "urdf")  # files of an arm; the others are JSON
JSON_FILES = ("drifts", "rotors", "summary", "friction", "residuals", "threshold")


class Model(Shown):
    """Torque constants, friction, links and residuals of an arm, as `ur5lib.fit` returns them.

    robot: the arm's name. `predict` gives the current of a motion (N, n), `score` its error,
    `friction` the friction at velocities (M,), `estimate` contact forces (N, 6); `table`, `use` and
    `plot` are the report's. SI units, in `attrs["units"]` of each frame. Raises InputError for
    recordings of another arm, or with a stop sign, and for unknown names.

        >>> pushed = ur5lib.read("pushed.csv", "ur5e", role="contact")
        >>> forces = model.estimate(pushed)
        >>> forces.attrs["units"]["Fmap_Fx"], forces.attrs["units"]["Fmap_nx"]
        ('N', 'Nm')
        >>> model.save("model.json")
    """

    def __init__(
        self, settings: Settings, robot: str, arm: Files, fitted: Mapping[str, Files]
    ) -> None:
        """Take the settings and what was fitted; `ur5lib.fit` and `load_model` call this."""
        self.robot = robot
        self._settings, self._arm, self._fitted = settings, arm, fitted

    @property
    def identified(self) -> Robot:
        """Return the description of the arm, with the link models that were identified."""
        robot: Robot = record_of(Robot, self._arm["arm"])
        return robot

    @property
    def _friction(self) -> Friction:
        """Torque constants and friction, with the fits that leave each path out."""
        friction: Friction = record_of(Friction, self._arm["friction"])
        return friction

    @property
    def use(self) -> pd.DataFrame:
        """Return the use of constants and frictions: joint, parameter, use (yes, no), and the code
        of the reason against it, or of a doubt.
        """
        return self.table("friction")[["joint", "parameter", "use", "reason"]]

    def table(self, name: str) -> pd.DataFrame:
        """Return a table of the arm as the report has it, one value a row, SI units: "friction",
        "torque_constants", "cross_validation", "rotor_inertia", "parameters", "excitation" or
        "remarks", with the units of its columns in `attrs["units"]`. Raises InputError for another
        name.

            >>> model.table("torque_constants").attrs["units"]["torque_constant"]
            'Nm/A'
        """
        expect_known("table", name, TABLES)
        files = {key: self._arm[file] for key, file in FILES_OF_TABLES.items()}
        files["calibration"] = "{}"  # no IMU is calibrated
        inputs: dict[str, Contents] = {key: {self.robot: file} for key, file in files.items()}
        inputs["judgements"] = {}
        tables = call("make_tables", inputs, {"parts": [], "unreadable": {}})
        table = as_written(tables[name])
        table.attrs["units"] = column_units(name, table, self.identified.measured.unit)
        return table

    def plot(self, name: str, joint: int | None = None) -> Figure:
        """Return a figure of the report, matplotlib's: "friction", "current_torque",
        "current_torque_friction", "residuals", "knowledge", "models" or "frames".

        joint: from 1, to have its panel alone, of the first three. Raises InputError for another
        name or joint, and of the first five where the model came from a file.

            >>> model.plot("friction", joint=3).axes[0].get_ylabel()
            'friction of joint 3 [Nm]'
        """
        expect_known("figure", name, FIGURES)
        joints = len(self.identified.joints)
        panels = range(1, joints + 1) if name in OF_JOINTS else ()
        if joint is not None and not (isinstance(joint, int | np.integer) and joint in panels):
            raise InputError(
                f"no panel of joint {joint!r:.80} in {name}; {', '.join(OF_JOINTS)} have one for "
                f"each of joints 1 to {joints}"
            )
        if name in OF_FRICTION and not all("signals" in own for own in self._moving()):
            raise InputError(
                f"{name} shows recordings, which the file of a model lacks; fit it again, or take "
                "it from its study: ur5lib.load(...).model(...)"
            )
        alone = Study.model_construct(
            study=self.robot, title="", settings=self._settings, recordings=[]
        )
        chain = Chain(Selection(alone), self.robot, self._arm, {}, self._fitted)
        figure = chain.result(FIGURES[name])[name].figure
        return figure if joint is None else figure.with_panel(joint)

    def predict(
        self, recordings: Recordings, accept: Mapping[str, str] | None = None
    ) -> pd.DataFrame:
        """Return predicted currents of motion without contact, as in currents.parquet of a study,
        and the measured ones.

        (N, n) each: `predicted_current_0` ..., half of its 95 % band `current_band_0` ..., the
        measured `actual_current_0` ..., and measured minus predicted, `residual_current_0` ...
        [A]; of an arm that measures torques, `torque` for `current` [Nm]. `tau_ext_0` ...: the
        external torque [Nm]. The band is of currents below the low-pass of the fit. A recording of
        the fit is predicted without its path. Index, accept, errors: as of `estimate`; and
        InputError where nothing is predicted.

            >>> model.predict(runs["free1"]).attrs["units"]["residual_current_0"]
            'A'
        """
        moving = self._predicted(recordings, accept)
        return frames({name: beside_measured(own, self._friction) for name, own in moving.items()})

    def score(
        self, recordings: Recordings, accept: Mapping[str, str] | None = None
    ) -> pd.DataFrame:
        """Return errors of predicted currents: the rows of a study's `current_rmse`, with `nrmse`.

        By recording, joint and model: `fitted` is this one, `least_squares` the plain one. nrmse:
        `rmse_lowpassed` over `zero_rmse_lowpassed`, the error of a constant current, so that 1 is
        no better than that, as of a joint that rests. fitted: `yes` of a recording of the fit,
        which is predicted without its path. A contact counts as an error. Arguments and errors: as
        of `predict`.

            >>> model.score(runs["free1"]).query("model == 'fitted'")["joint"].tolist()
            [1, 2, 3, 4, 5, 6]
        """
        return errors(self._predicted(recordings, accept), self._friction)

    def friction(self, velocity: ArrayLike, load: ArrayLike = 0.0) -> pd.DataFrame:
        """Return the friction of each joint at steady velocities, all terms together.

        velocity: one, or (M,) [rad/s]; at 0, as a joint begins to move in positive direction; load:
        size of the torque that a gear transmits [Nm], one, or (n,) by joint. `tau_friction_0` ...
        [Nm] with their standard deviations `tau_friction_std_0` ..., (M, n) each, by `velocity`.
        Springs, rotors and coupled motors are not in it. Raises InputError if velocity or load are
        not numbers.

            >>> model.friction([0.1, 0.5], load=20.0).shape
            (2, 12)
        """
        return friction_at(self._friction, velocity, load)

    def estimate(
        self, recordings: Recordings, accept: Mapping[str, str] | None = None
    ) -> pd.DataFrame:
        """Return the estimated contact wrenches of recordings, as forces.parquet of a study has
        them: `Fmap_Fx` ... `Fmap_nz` [N, Nm], `Fmap_std_Fx` ..., and `log_odds_Fmap` of a contact;
        `untouched_x` ... and `hidden_x` ... [N], see `FinishedStudy.forces`.

        The environment on the arm, base axes, at the origin of frame 6; NaN where nothing is known.
        `time` [s] is the index, of several recordings `recording` and `time`. accept: reasons for
        which stop signs are overruled, by kind. Raises InputError for recordings of another arm, or
        with a stop sign.

            >>> model.estimate(runs["free1"]).attrs["units"]["Fmap_std_nx"]
            'Nm'
        """
        steps = ("estimate_load", "predict_currents", "estimate_forces")
        moving = self._run(recordings, accept, *steps)
        return frames({name: forces_of(own["forces"]) for name, own in moving.items()})

    def _predicted(
        self, recordings: Recordings, accept: Mapping[str, str] | None
    ) -> dict[str, Files]:
        moving = self._run(recordings, accept, "estimate_load", "predict_currents")
        expect_predicted(moving, self._friction)
        return moving

    def _run(
        self, recordings: Recordings, accept: Mapping[str, str] | None, *steps: str
    ) -> dict[str, Files]:
        """Return by name the files of the recordings in motion after some steps; raises as
        `estimate`.
        """
        recordings = as_recordings(recordings)._accepting(accept)
        self._expect_arm_of(recordings)
        study = recordings._study.model_copy(update={"settings": self._settings})
        made = recordings._chain(study)
        chain = replace(made, arm=self._arm, several=self._fitted)
        moving = {name: own for name, own in made.recordings.items() if "robot" in own}
        if not moving:
            raise InputError(
                f"{', '.join(recordings.names)}: postures at rest tell no contact force"
            )
        for name in moving:
            for step in ("align_recording", "compute_torques"):
                chain.run(step, name)
        expect_no_stop_sign(moving)
        for name in moving:
            for step in steps:
                chain.run(step, name)
        return moving

    def save(self, path: str | Path) -> None:
        """Write the model as JSON, which `ur5lib.load_model` reads; its recordings stay out.

        Raises InputError where the file cannot be written.
        """
        write_text(json.dumps(self._saved(), indent=1) + "\n", expect_text(path, "file"))

    @classmethod
    def _read(cls, path: str | Path) -> Model:
        """Read a model that was saved. Raises InputError where the file has none."""
        file = Path(expect_text(path, "file"))
        try:
            saved = json.loads(file.read_text(encoding="utf-8"))
            texts: Files = {name: saved["arm"][name] for name in YAML_FILES}
            texts |= {name: _text(saved["arm"][name]) for name in JSON_FILES}
            fitted: dict[str, Files] = {
                name: {part: _text(own) for part, own in parts.items()}
                for name, parts in saved["fitted"].items()
            }
            settings = Settings.model_validate(saved["settings"])
            model = cls(settings, str(saved["robot"]), texts, fitted)
            model._expect_readable()
        except OSError as error:
            raise InputError(f"{path} cannot be read ({error.strerror}); check its name") from error
        except (LookupError, ArithmeticError, TypeError, AttributeError, ValueError) as error:
            raise InputError(
                f"{path} holds no model of this version ({type(error).__name__}: "
                f"{str(error).splitlines()[0]}); save it anew by `model.save`"
            ) from error
        return model

    def __eq__(self, other: object) -> bool:
        """Return whether two models have the same content."""
        return isinstance(other, Model) and self._saved() == other._saved()

    __hash__ = None  # type: ignore[assignment]

    def _saved(self) -> dict[str, Any]:
        texts = {name: text_of(self._arm[name]) for name in YAML_FILES}
        plain = {name: json.loads(text_of(self._arm[name])) for name in JSON_FILES}
        loads = {
            name: {part: json.loads(text_of(own[part])) for part in ("payload",) if part in own}
            for name, own in self._fitted.items()
        }
        return {
            "ur5lib": __version__,
            "robot": self.robot,
            "settings": self._settings.model_dump(mode="json"),
            "arm": texts | plain,
            "fitted": loads,
        }

    def _expect_readable(self) -> None:
        """Read each of the model's files, and make its tables, so that damaged ones raise
        InputError.
        """
        loads = get_args(parameter_types(step_named("predict_currents"))["unloaded"])[1]
        for own in self._fitted.values():
            for content in own.values():
                record_of(loads, content)
        record_of(Robot, self._arm["described"])
        record_of(parameter_types(step_named("align_recording"))["drifts"], self._arm["drifts"])
        record_of(dict[str, float], self._arm["threshold"])
        self.table(TABLES[0])

    def _expect_arm_of(self, recordings: Recordings) -> None:
        if recordings.robot != self.robot:
            raise InputError(
                f"the model is of {self.robot}, but {', '.join(recordings.names)} of "
                f"{recordings.robot}; read them with the arm of the model"
            )
        if text_of(recordings._arm["described"]) != text_of(self._arm["described"]):
            raise InputError(
                f"{self.robot} is described otherwise than when the model was fitted; fit it again"
            )

    def _moving(self) -> list[Files]:
        return [own for name, own in self._fitted.items() if name in self._friction.from_]

    def _title(self) -> str:
        friction = self._friction
        learnt = [*friction.from_, *friction.at_rest]
        links = "identified" if "identified" in self.identified.models else "as described"
        fitted = f"fitted to {some(learnt, 4)} on {counted(friction.paths, 'path')}; links {links}"
        if not learnt:
            fitted = "no recording has the role `fit`: friction is only what other arms have"
        return f"Model of {self.robot}, {fitted}; it estimates forces where no stop sign is found"

    def summary(self) -> pd.DataFrame:
        """Return the first parameters by joint, each with its 95 % interval."""
        table = self.table("friction")
        table = table[table["parameter"].isin(PARAMETER_UNITS)]
        names = [f"{name} [{PARAMETER_UNITS[name]}]" for name in table["parameter"]]
        cells = [_interval(row) for row in table.itertuples()]
        shown = table.assign(parameter=names, cell=cells)
        wide = shown.pivot_table(
            index="joint", columns="parameter", values="cell", aggfunc="first", sort=False
        )
        return wide.reset_index().rename_axis(columns=None)


def fit(recordings: Recordings, accept: Mapping[str, str] | None = None) -> Model:
    """Fit torque constants, friction, links and residuals to the recordings of the role `fit`.

    The steps, settings and selection are those of a study. accept: reasons for which stop signs
    are overruled, by their kind, as `accept` of a study. Without such recordings, friction is that
    of other arms. On a terminal, a bar shows the steps. Raises InputError where a stop sign forbids
    a fit, and where too little was recorded.

        >>> model = ur5lib.fit(runs)
        >>> len(model.table("torque_constants"))
        6
    """
    recordings = as_recordings(recordings)._accepting(accept)
    chain = recordings._chain(recordings._study)
    names = chain.selection.of_arm(chain.robot, "fit")
    at_rest = chain.selection.of_arm(chain.robot, "fit", at_rest=True)
    free = chain.selection.of_arm(chain.robot, "fit", "validate")
    replace(chain, several={one: chain.recordings[one] for one in free}).run("pool_drifts")
    fitted = {one: chain.recordings[one] for one in [*names, *at_rest]}
    chain = replace(chain, several=fitted)
    aligned = [one for one in chain.selection.before(*names) if one in chain.recordings]
    torques = [("align_recording", one) for one in dict.fromkeys([*aligned, *names])]
    torques += [("identify_model", ""), *product(["compute_torques"], names)]
    forces = [(step, one) for one in names for step in ("estimate_load", "predict_currents")]
    forces += [("fit_residuals", ""), *product(["estimate_forces"], names), ("set_threshold", "")]
    with bar(len(torques) + 1 + len(forces)) as advance:

        def run(*jobs: tuple[str, str]) -> None:
            for step, one in jobs:
                advance(f"{step} {one}")
                chain.run(step, one)

        run(*torques)
        expect_no_stop_sign({name: fitted[name] for name in names})
        run(("fit_friction", ""))
        model = Model(recordings._study.settings, chain.robot, chain.arm, fitted)
        refused = model._friction.stopped or model._friction.refused
        if refused is not None:
            raise InputError(f"{chain.robot}: {refused.sentence()}")
        run(*forces)
    return model


def load_model(path: str | Path) -> Model:
    """Return a model that `Model.save` wrote. Raises InputError where the file has none.

    >>> ur5lib.load_model("model.json") == model
    True
    """
    return Model._read(path)


def expect_no_stop_sign(files: Mapping[str, Files]) -> None:
    """Raise InputError that lists the stop signs of all recordings, if there are any; files: by
    recording.
    """
    signs = [
        f"{name}: {sign.sentence()}"
        for name, own in files.items()
        for sign in record_of(Premises, own["premises"]).contradictions.stop_signs
    ]
    if signs:
        raise InputError("\n".join(signs))


def _interval(row: Any) -> str:
    if row.determined != "yes":
        return f"{row.value:.4g} (not determined)"
    return f"{row.value:.4g} ({row.low:.4g} to {row.high:.4g})"


def _text(plain: object) -> str:
    return json.dumps(plain, indent=2) + "\n"
