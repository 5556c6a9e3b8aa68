"""The steps of a study in memory: each receives the arguments of its signature."""

from collections.abc import Mapping
from dataclasses import dataclass
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, get_origin

from ur5lib.jobs.code import of_study
from ur5lib.jobs.files import parameter_types
from ur5lib.jobs.job import step_named
from ur5lib.jobs.memory import Content, Contents, call, contents
from ur5lib.robots.description import robot_path
from ur5lib.study.given import given
from ur5lib.study.selection import Selection

Files = dict[str, Content]  # of a recording or an arm, by name
# Names of single results of steps, by which other steps receive them.
RESULTS = {
    "describe_arm": "described",
    "pool_drifts": "drifts",
    "fit_friction": "friction",
    "estimate_load": "payload",
    "fit_residuals": "residuals",
    "estimate_forces": "forces",
    "set_threshold": "threshold",
}
# Steps that receive the arm as described; the others receive it with the identified models.
OF_DESCRIBED = {"read_recording", "read_postures", "identify_model"}
OF_DESCRIBED |= {"estimate_forces", "set_threshold"}
OTHER_NAMES = {"unloaded": "payload"}  # parameters with another name than their files


@dataclass(frozen=True)
class Chain:
    """The results of the steps of one arm so far.

    selection: the recordings and their settings; robot: the arm's name; arm: the contents of its
    files, by name; recordings: the same for each recording that steps run for; several: the same
    for each recording that a step of the arm receives, in the study's order.
    """

    selection: Selection
    robot: str
    arm: Files
    recordings: Mapping[str, Files]
    several: Mapping[str, Files]

    def run(self, step: str, recording: str = "") -> None:
        """Run a step for a recording, or for the arm if recording is "", and keep its results."""
        own = self.recordings[recording] if recording else self.arm
        own |= contents(RESULTS.get(step, ""), self.result(step, recording))

    def result(self, step: str, recording: str = "") -> Any:
        """Return the result of a step for a recording, or for the arm if recording is ""."""
        params = given(step, self.selection, recording or self.robot)
        params |= self._paths(step, recording)
        own = self.recordings[recording] if recording else {}
        inputs: dict[str, Contents] = {}
        function = step_named(step)
        for parameter, kind in parameter_types(function).items():
            name = OTHER_NAMES.get(parameter, parameter)
            if parameter == "arm" and step in OF_DESCRIBED:
                name = "described"
            if parameter in params:
                continue
            if parameter == "before":
                inputs[parameter] = self._motions_before(recording)
            elif get_origin(kind) is Mapping:
                found = {one: files[name] for one, files in self.several.items() if name in files}
                taken = signature(function).parameters.get(parameter)
                if found or (taken and taken.default is Parameter.empty):
                    inputs[parameter] = found
            elif name in own or name in self.arm:
                inputs[parameter] = own[name] if name in own else self.arm[name]
        return call(step, inputs, params)

    def _motions_before(self, recording: str) -> dict[str, Content]:
        """Return by name the smoothed motions of the recordings that precede a recording (`after`
        in the study), or without a recording those that precede the arm's `fit` recordings.
        """
        names = [recording] if recording else self.selection.of_arm(self.robot, "fit")
        before = self.selection.before(*names)
        files = {one: self.recordings.get(one, {}) for one in before}
        return {one: own["motion"] for one, own in files.items() if "motion" in own}

    def _paths(self, step: str, recording: str) -> dict[str, list[Path]]:
        """Return the user's files that a step reads, by the names of its parameters."""
        if step == "describe_arm":
            arm = self.selection.study.arms()[self.robot]
            own = of_study([robot_path(arm.arm)])
            calibration = [arm.calibration] if arm.calibration else []
            return {"description": [*map(Path, own)], "calibration": [*map(Path, calibration)]}
        if step in ("read_recording", "read_postures"):
            return {"raw": [*map(Path, self.selection.raw_files(recording))]}
        return {}
