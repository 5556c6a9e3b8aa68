"""A fitted model in the formats of `ur5 export`, and its results as a folder of a study."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from ur5lib.chain.steps import Chain, Files
from ur5lib.commands.exported import FOLDERS, FORMATS, exported
from ur5lib.errors import InputError, expect_known
from ur5lib.jobs.code import module_of
from ur5lib.jobs.declared import Declared, every, is_figure, written_by
from ur5lib.jobs.files import arguments, write
from ur5lib.jobs.job import step_named
from ur5lib.jobs.memory import contents
from ur5lib.study.model import Study
from ur5lib.study.reading import study_text
from ur5lib.study.selection import Selection
from ur5lib.tables import made, write_text
from ur5lib.workspace.topics import modules_of_topics

if TYPE_CHECKING:
    from ur5lib.chain.model import Model

READ = {  # by make_tables and judge_study, of a fit in memory
    "described": "parameters/*/described.yaml",
    "identified": "parameters/*/arm.yaml",
    "rotors": "parameters/*/rotor_inertia.json",
    "identification": "parameters/*/identification.json",
    "friction": "parameters/*/friction.json",
    "residuals": "parameters/*/residuals.json",
    "calibration": "parameters/*/imu.json",
    "parts": "parameters/*/*.csv",
    "judgements": "recordings/*/judgement.json",
}


def exported_model(
    model: "Model", to: str, link_model: str | None, as_in: str, ros_names: bool, accept: str
) -> str:
    """Return a model as the file that `ur5 export` writes; see `Model.export` and `exported`."""
    if expect_known("format", to, FORMATS) in FOLDERS:
        raise InputError(f"{to} has several files; `ur5 export --format {to}` writes their folder")
    with results_of(model, to) as folder:
        try:
            text = exported(model.robot, link_model, to, folder, as_in, ros_names, accept)
            return text + "\n"
        except InputError as error:
            raise InputError(in_python(str(error), str(folder))) from error


@contextmanager
def results_of(model: "Model", to: str = "") -> Iterator[Path]:
    """Provide the folder of results of a model's study; of one that was fitted in memory, a folder
    with those of its recordings of the fit, for a while.

    to: format for which they are.
    """
    if isinstance(model._source, Path):
        yield model._source
        return
    if model._source is None:
        raise InputError(
            f"the file of a model of {model.robot} lacks the recordings, by which its fit is "
            "judged; fit it again, or take it from its study: ur5lib.load(...).model(...)"
        )
    with TemporaryDirectory() as folder:
        write_results(model, model._source, to, Path(folder))
        yield Path(folder)


def write_results(model: "Model", source: Study, to: str, folder: Path) -> None:
    """Write the results of a fit, judged as those of a study are."""
    recordings = {name: dict(own) for name, own in model._fitted.items()}
    entries = [one for one in source.recordings if one.name in recordings]
    study = source.model_copy(update={"recordings": entries, "settings": model._settings})
    chain = Chain(Selection(study), model.robot, dict(model._arm), recordings, recordings)
    sensed = [written_by()["further"][0].name, "judge_sensor"] if to == "sensor" else []
    for name, own in recordings.items():
        for step in ("judge_recording", *sensed) if "signals" in own else ():
            chain.run(step, name)
        _put(own, folder / "recordings" / name)
    place = folder / "parameters" / model.robot
    write_text("{}", made(place) / "imu.json")  # no IMU is calibrated
    _put(chain.arm, place)
    topics = modules_of_topics("exports").items()
    for own_step in _steps_of_arm(next((name for name, own in topics if to in own.FORMATS), "")):
        result = chain.result(own_step.name)
        chain.arm.update(contents(next(iter(own_step.writes)), result))
        write(step_named(own_step.name), result, _paths(own_step.writes, place))
    write_text(study_text(study), folder / "configuration.yaml")
    _write_tables(study_text(study), chain.selection, folder)


def _put(files: Files, folder: Path) -> None:
    """Write files in memory under the names that they have in a study."""
    for output, content in files.items():
        path = made(folder) / written_by()[output][1]
        if isinstance(content, str):
            write_text(content, path)
        else:
            path.write_bytes(
                content.read_bytes() if isinstance(content, Path) else content.getvalue()
            )


def _steps_of_arm(topic: str) -> list[Declared]:
    """Return the steps of a topic that run for an arm, each after those whose outputs it reads."""
    own = [one for one in every() if topic and module_of(one.name).parent.name == topic]
    left, done = [one for one in own if one.of == "arm" and not is_figure(one)], list[Declared]()
    while left:
        unmade = {output for one in left for output in one.writes}
        done += [one for one in left if not unmade & {*one.reads.values()}]
        left = [one for one in left if one not in done]
    return done


def _paths(writes: Mapping[str, str], folder: Path) -> dict[str, str]:
    return {output: str(made(folder) / file) for output, file in writes.items()}


def _write_tables(study: str, selection: Selection, folder: Path) -> None:
    """Write the tables of a study and its verdicts, as its rules do."""
    files = {name: [*map(str, folder.glob(pattern))] for name, pattern in READ.items()}
    roles = {name: one.role for name, one in selection.entries.items()}
    tables = step_named("make_tables")
    made_tables = tables(**arguments(tables, files, {"unreadable": {}, "roles": roles}))
    names = {name: f"{name}.csv" for name in made_tables}
    write(tables, made_tables, _paths(names, folder / "tables"))
    judge = step_named("judge_study")
    files |= {"tables": [*_paths(names, folder / "tables").values()], "of_topics": []}
    judged = judge(**arguments(judge, files, {"study": study}))
    write(judge, judged, _paths({n: f"{n}.csv" for n in judged._fields}, folder / "tables"))


def in_python(message: str, folder: str) -> str:
    """Return a message of `ur5 export` for callers in Python: arguments in place of options."""
    message = message.replace(folder, "this fit")
    message = re.sub(r"--(accept) \"", r'\1="', message)
    message = message.replace("--model", "`link_model`").replace("--as-in", "`as_in`")
    return re.sub(r"--(format|results)\b", r"`\1`", message.replace("--ros-names", "`ros_names`"))
