"""The steps of a study in memory: each receives what it declares."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ur5lib.jobs.declared import Declared, declared
from ur5lib.jobs.memory import Content, Contents, call, contents
from ur5lib.study.given import FILES, OF_OTHERS, setting
from ur5lib.study.selection import Selection

Files = dict[str, Content]  # of a recording or an arm, by name


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
        output = next(iter(_declared(step).writes))
        own |= contents(output, self.result(step, recording))

    def result(self, step: str, recording: str = "") -> Any:
        """Return the result of a step for a recording, or for the arm if recording is ""."""
        own, name = _declared(step), recording or self.robot
        inputs, params = dict[str, Contents](), dict[str, Any]()
        for parameter, source in own.reads.items():
            if source in FILES:
                params[parameter] = [*map(Path, FILES[source](self.selection, name))]
            elif given := setting(own.of, own.recordings, source):
                params[parameter] = given(self.selection, name)
            elif (found := self._found(source, parameter in own.several, name)) is not None:
                inputs[parameter] = found
        return call(step, inputs, params)

    def _found(self, source: str, several: bool, name: str) -> Contents | None:
        """Return an output of a recording or its arm, or those of several; None without it."""
        if source in OF_OTHERS:
            output, others = OF_OTHERS[source]
            every = {**self.several, **self.recordings}
            chosen = {one: every[one] for one in others(self.selection, name) if one in every}
            return {one: files[output] for one, files in chosen.items() if output in files}
        if several:
            return {one: files[source] for one, files in self.several.items() if source in files}
        return self.recordings.get(name, {}).get(source, self.arm.get(source))


def _declared(step: str) -> Declared:
    own = declared(step)
    assert own is not None, f"{step} runs for a whole study"
    return own
