"""The model of an arm: fitted to recordings, shown, saved, and used on other recordings."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ur5lib import __version__
from ur5lib.chain.efforts import (
    Angles,
    Effort,
    Fits,
    Load,
    Rates,
    States,
    asked,
    effort_of_recording,
    effort_of_states,
    joined,
    motion_before,
    payload_of,
)
from ur5lib.chain.estimator import Estimator, Terms
from ur5lib.chain.predicted import beside_measured, errors, expect_predicted, friction_at
from ur5lib.chain.recordings import Recordings, as_recordings, forces_of
from ur5lib.chain.shown import Shown, bar, counted, frames
from ur5lib.chain.steps import Chain, Files
from ur5lib.channels import CURRENT
from ur5lib.errors import (
    InputError,
    RecordingWarning,
    Remark,
    briefly,
    expect_known,
    expect_text,
    some,
)
from ur5lib.jobs.files import parameter_types
from ur5lib.jobs.job import step_named
from ur5lib.jobs.memory import Contents, call, record_of, text_of
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.prediction import Prediction, held_throughout
from ur5lib.records.premises import Premises
from ur5lib.records.units import column_units
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import PARAMETER_UNITS
from ur5lib.study.model import Settings, Study
from ur5lib.study.selection import Selection
from ur5lib.tables import as_written, read_footer, write_text
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth

if TYPE_CHECKING:  # these load for a while, and few need them
    from matplotlib.figure import Figure

    from ur5lib.chain.single import Single

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
OF_RECORDINGS = (*OF_JOINTS, "residuals")
OF_FRICTION = (*OF_RECORDINGS, "knowledge")
OF_MODELS = ("models", "frames")
FIGURES = dict.fromkeys(OF_FRICTION, "draw_friction") | dict.fromkeys(OF_MODELS, "draw_models")
YAML_FILES = ("described", "arm", "urdf")  # files of an arm; the others are JSON
JSON_FILES = ("drifts", "rotors", "summary", "friction", "residuals", "threshold")


class Model(Estimator, Shown):
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

    @classmethod
    def _of(
        cls,
        settings: Settings,
        robot: str,
        arm: Files,
        fitted: Mapping[str, Files],
        source: Path | None = None,
    ) -> Model:
        """Return a model that was fitted; source: folder of the results of its study."""
        return cls()._with(settings, robot, arm, fitted, source)

    def _with(
        self,
        settings: Settings,
        robot: str,
        arm: Files,
        fitted: Mapping[str, Files],
        source: Study | Path | None,
    ) -> Model:
        """Take what was fitted, and return the model; source: its study, or the folder of its
        results, None of a file.
        """
        self.robot = robot
        self._settings, self._arm, self._fitted = settings, arm, fitted
        self._source = source
        return self

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Raise InputError for what only a fit has."""
            if name in ("robot", "_settings", "_arm", "_fitted"):
                raise InputError("this model is not fitted yet; call its `fit`, or ur5lib.fit")
            raise AttributeError(f"a Model has no {name}")

    def fit(
        self,
        recordings: Recordings | Sequence[Recordings],
        y: None = None,  # noqa: ARG002 - of scikit-learn, which has no use here
        accept: Mapping[str, str] | None = None,
    ) -> Model:
        """Fit the model anew, with its arguments, and return it; see `ur5lib.fit`."""
        recordings = as_recordings(recordings)._accepting(accept)
        study = recordings._study
        changed = study.model_copy(update={"settings": self._changed(study.settings)})
        chain, fitted = fitted_chain(recordings._chain(changed))
        return self._with(changed.settings, chain.robot, chain.arm, fitted, changed)

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
        name or joint, and of the first four where the model came from a file.

            >>> model.plot("friction", joint=3).axes[0].get_ylabel()
            'friction of joint 3 [Nm]'
        """
        expect_known("figure", name, FIGURES)
        joints = len(self.identified.joints)
        panels = range(1, joints + 1) if name in OF_JOINTS else ()
        if joint is not None and not (isinstance(joint, int | np.integer) and joint in panels):
            raise InputError(
                f"no panel of joint {briefly(joint)} in {name}; {', '.join(OF_JOINTS)} have one "
                f"for each of joints 1 to {joints}"
            )
        if name in OF_RECORDINGS and not all("signals" in own for own in self._moving()):
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

    @asked
    def torque(
        self,
        q: Angles,
        qd: Rates = None,
        qdd: Rates = None,
        *,
        payload: Load = None,
        period: float | None = None,
        after: Rates = None,
        return_std: bool = False,
    ) -> Array | tuple[Array, Array]:
        """Return the torques [Nm] of the motors in a motion that nothing touches: links, rotors,
        payload, friction. No measured effort is used.

        q, qd, qdd: one state (n,), or (N, n) [rad, rad/s, rad/s²]; qd and qdd may be 0. Rows of
        arrays are states in any order, each of joints that have moved like that for long. A frame
        by `time` [s], or rows with a `period` [s], are one motion, at whose turns friction reverses
        gradually; after: angles (M, n) of the motion before it, without which its start is
        uncertain. Recordings: their own motion, payload and mounting, one after the other as in
        `runs.q`; a recording of the fit by the fit without its path, as `predict` does.

        payload: mass on the flange [kg], or (mass, its centre (3,) in the last frame [m]), of a
        recording in addition to what its study declares. Returns (n,) or (N, n); with return_std,
        the standard deviation of what is below the low-pass of the fit, too. Raises InputError for
        other shapes.

            >>> model.torque([0, -1.5, 1.5, 0, 0, 0], 0, 0).shape
            (6,)
        """
        found = self._efforts(q, qd, qdd, payload, period, after)
        if self._friction.measured == CURRENT:
            found = [one.as_torque() for one in found]
        return joined(found, return_std)

    @asked
    def current(
        self,
        q: Angles,
        qd: Rates = None,
        qdd: Rates = None,
        *,
        payload: Load = None,
        period: float | None = None,
        after: Rates = None,
        return_std: bool = False,
    ) -> Array | tuple[Array, Array]:
        """Return the motor currents [A] of a motion that nothing touches; all else as of `torque`.

        Raises InputError for an arm that measures torques.

            >>> current, std = model.current([0, -1.5, 1.5, 0, 0, 0], 0, 0, return_std=True)
            >>> bool((std > 0).all())
            True
        """
        if self._friction.measured != CURRENT:
            raise InputError(f"{self.robot} measures torques; ask `model.torque` for them")
        return joined(self._efforts(q, qd, qdd, payload, period, after), return_std)

    def friction(self, velocity: ArrayLike, load: ArrayLike = 0.0) -> pd.DataFrame:
        """Return the friction of each joint at steady velocities, all terms together.

        velocity [rad/s]: one, or (M,), of all joints alike, or (N, n) by joint; at 0, as a joint
        begins to move in positive direction; load: size of the torque that a gear transmits [Nm],
        one, (n,) by joint, or as velocity (N, n). `tau_friction_0` ... [Nm] with their standard
        deviations `tau_friction_std_0` ..., (M, n) each, by `velocity`, or by row. Springs, rotors
        and coupled motors are not in it. Raises InputError if velocity or load are not numbers,
        and where no fit was possible.

            >>> model.friction([0.1, 0.5], load=20.0).shape
            (2, 12)
        """
        return friction_at(self._expect_fit(), velocity, load)

    def single(self, payload: Load = None) -> Single:
        """Return the same for one state (n,) in microseconds, for a controller in Python: torque,
        current, friction, inverse and forward dynamics, gravity, mass matrix and Jacobian.

        payload: as of `torque`. Raises InputError without Pinocchio, an extra of ur5lib.

            >>> model.single().gravity(runs["free1"].q.to_numpy()[0]).shape
            (6,)
        """
        from ur5lib.chain.single import Single  # scipy and Pinocchio load for a while

        arm = self.identified.carrying(payload_of(payload, len(self.identified.joints)))
        friction = self._expect_fit()
        return Single(arm, Fits(friction.fit, friction.usual), friction.measured == CURRENT)

    def _efforts(
        self, q: Any, qd: Any, qdd: Any, payload: Load, period: float | None, after: Any
    ) -> list[Effort]:
        """Return the effort of a motion, of recordings one after the other; see `torque`."""
        if isinstance(q, Recordings):
            if any(one is not None for one in (qd, qdd, period, after)):
                raise InputError("recordings have their own motion; leave out qd, qdd and times")
            return self._efforts_of(q, payload)
        joints, friction = len(self.identified.joints), self._expect_fit()
        states = States.of(q, qd, qdd, period, joints)
        before = [] if after is None else motion_before(after, states, joints)
        arm = self.identified.carrying(payload_of(payload, joints))
        fits = Fits(friction.fit, friction.usual)
        return [effort_of_states(states, arm, fits, self._lowpass(), before)]

    def _efforts_of(self, recordings: Recordings, payload: Load) -> list[Effort]:
        friction, moving = self._expect_fit(), self._run(recordings, None)
        load = payload_of(payload, len(self.identified.joints))
        selection = Selection(recordings._study)
        motions = {name: record_of(Motion, own["motion"]) for name, own in moving.items()}
        return [
            effort_of_recording(
                own,
                self.identified.mounted(selection.gravity(name)),
                load,
                Fits(friction.fit_for(name), friction.usual),
                self._lowpass(),
                motions_before(motions[name], selection.before(name), motions),
                selection.date(name),
            )
            for name, own in moving.items()
        ]

    def _expect_fit(self) -> Friction:
        """Return the friction. Raises InputError where none could be fitted."""
        friction = self._friction
        if not friction.fit.joints:
            cause = friction.stopped or friction.refused
            why = cause.sentence() if cause else "nothing was recorded"
            raise InputError(f"{self.robot} has no map from motion to {friction.effort}: {why}")
        return friction

    def _lowpass(self) -> Butterworth:
        design = self._settings.lowpass.currents
        return Butterworth(design.order, design.cutoff_hz)

    def estimate(
        self, recordings: Recordings, accept: Mapping[str, str] | None = None
    ) -> pd.DataFrame:
        """Return the estimated contact wrenches of recordings, as forces.parquet of a study has
        them: `Fmap_Fx` ... `Fmap_nz` [N, Nm], `Fmap_std_Fx` ..., and `log_odds_Fmap` of a contact;
        `untouched_x` ... and `hidden_x` ... [N], `link` and `off_flange`, see
        `FinishedStudy.forces`.

        The environment on the arm, base axes, at the origin of frame 6; NaN where nothing is known.
        A load that is held throughout is taken off, and warned of. `time` [s] is the index, of
        several recordings `recording` and `time`. accept: reasons for
        which stop signs are overruled, by kind. Raises InputError for recordings of another arm, or
        with a stop sign.

            >>> model.estimate(runs["free1"]).attrs["units"]["Fmap_std_nx"]
            'Nm'
        """
        steps = ("estimate_load", "predict_currents", "estimate_forces")
        moving = self._run(recordings, accept, *steps)
        for name, own in moving.items():
            if {*read_footer(own["forces"]).schema.names} <= {"time", "segment"}:
                told = f"{name}: no force is told, for {self._why_no_force()}"
                warnings.warn(told, RecordingWarning, stacklevel=2)
            load = record_of(Prediction, own["prediction"]).load
            if load is not None and load.taken:
                told = f"{name}: {held_throughout(load)}; what presses for as long looks alike"
                warnings.warn(told, RecordingWarning, stacklevel=2)
        return frames({name: forces_of(own["forces"]) for name, own in moving.items()})

    def _why_no_force(self) -> str:
        kind = parameter_types(step_named("estimate_forces"))["residuals"]
        refused: Remark | None = record_of(kind, self._arm["residuals"]).refused
        return refused.text if refused else f"no {self._friction.effort} was recorded"

    def _predicted(
        self, recordings: Recordings, accept: Mapping[str, str] | None
    ) -> dict[str, Files]:
        moving = self._run(recordings, accept, "estimate_load", "predict_currents")
        expect_predicted(moving, self._friction)
        return moving

    def _run(
        self,
        recordings: Recordings,
        accept: Mapping[str, str] | None,
        *steps: str,
        before: Mapping[str, Files] | None = None,
    ) -> dict[str, Files]:
        """Return by name the files of the recordings in motion after some steps; before: files of
        others that they follow; raises as `estimate`.
        """
        recordings = as_recordings(recordings)._accepting(accept)
        self._expect_arm_of(recordings)
        study = recordings._study.model_copy(update={"settings": self._settings})
        made = recordings._chain(study)
        chain = replace(made, arm=self._arm, several={**self._fitted, **(before or {})})
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

    def export(
        self,
        format: str = "urdf",
        *,
        link_model: str | None = None,
        as_in: str = "",
        ros_names: bool = False,
        accept: str = "",
    ) -> str:
        """Return the arm's text for another program, as `ur5 export` of its study gives it.

        format: "urdf", "mjcf", "sdf", "isaac", "json", "live", "live.py", "live.hpp", "sensor",
        "thresholds" and others, see docs/exports.md; link_model: one of `model.identified.models`,
        by default the fullest; as_in: a recording with the payload, mounting and tool to use;
        ros_names: call the joints of a UR as ROS does; accept: why to export what the verdicts say
        not to use, which the text then states. Raises InputError for such verdicts without a
        reason, unknown names, and a model from a file.

            >>> model.export("urdf").splitlines()[0]
            '<robot name="ur5e">'
        """
        import ur5lib  # commands are above

        answer = ur5lib.exported_model(self, format, link_model, as_in, ros_names, accept)
        return str(answer)

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
            model = cls._of(settings, str(saved["robot"]), texts, fitted)
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
        if "_arm" not in vars(self):
            told = ", ".join(f"{name}={value!r}" for name, value in self.get_params().items())
            return f"Model({told}), not fitted yet"
        friction = self._friction
        learnt = [*friction.from_, *friction.at_rest]
        links = "identified" if "identified" in self.identified.models else "as described"
        fitted = f"fitted to {some(learnt, 4)} on {counted(friction.paths, 'path')}; links {links}"
        if not learnt:
            fitted = "no recording has the role `fit`: friction is only what other arms have"
        return f"Model of {self.robot}, {fitted}; it estimates forces where no stop sign is found"

    def summary(self) -> pd.DataFrame:
        """Return the first parameters by joint, each with its 95 % interval."""
        if "_arm" not in vars(self):
            return pd.DataFrame()
        table = self.table("friction")
        table = table[table["parameter"].isin(PARAMETER_UNITS)]
        names = [f"{name} [{PARAMETER_UNITS[name]}]" for name in table["parameter"]]
        cells = [_interval(row) for row in table.itertuples()]
        shown = table.assign(parameter=names, cell=cells)
        wide = shown.pivot_table(
            index="joint", columns="parameter", values="cell", aggfunc="first", sort=False
        )
        return wide.reset_index().rename_axis(columns=None)


def fit(
    recordings: Recordings | Sequence[Recordings],
    accept: Mapping[str, str] | None = None,
    *,
    cutoff_hz: float | None = None,
    terms: Terms | None = None,
    prior: bool | None = None,
) -> Model:
    """Fit torque constants, friction, links and residuals to the recordings of the role `fit`.

    The steps, settings and selection are those of a study. accept: reasons for which stop signs
    are overruled, by their kind, as `accept` of a study. cutoff_hz: of the low-pass of currents
    [Hz]; terms: of friction besides Coulomb, viscous and load friction, names or `Term`s with a
    name, () for none; prior: whether a UR's friction is expected to be as that of other URs; None:
    as the study says. Without such recordings, friction is that of other arms. On a terminal, a bar
    shows the steps. Raises InputError where a stop sign forbids a fit, and where too little was
    recorded.

        >>> model = ur5lib.fit(runs)
        >>> len(model.table("torque_constants"))
        6
    """
    return Model(cutoff_hz=cutoff_hz, terms=terms, prior=prior).fit(recordings, accept=accept)


def fitted_chain(chain: Chain) -> tuple[Chain, Mapping[str, Files]]:
    """Return the steps of a fit after all of them ran, and the files of the recordings of the fit.

    Raises as `fit`.
    """
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
        friction: Friction = record_of(Friction, chain.arm["friction"])
        refused = friction.stopped or friction.refused
        if refused is not None:
            raise InputError(f"{chain.robot}: {refused.sentence()}")
        run(*forces)
    return chain, fitted


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
