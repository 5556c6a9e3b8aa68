"""Many recordings as few jobs: what each goes through by itself, in batches of recordings.

Snakemake plans in a time that grows with its jobs and files. A study of many recordings therefore
has one job for a batch of recordings and a level: the steps between two points at which recordings
wait for each other, as for what is fitted to all of an arm. Its only file is a stamp. Which of its
steps run is decided for each recording, see `ur5lib.steps.upkeep`.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from graphlib import TopologicalSorter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ur5lib.steps.absent import STAMPS, left_out, name_of
from ur5lib.steps.job import Job, Names, paths

NUMBER = 32  # fewest batches of many recordings, which are at most twice as many
Values = Mapping[str, Any]  # declared by name: constants, texts with wildcards, functions of these


@dataclass(frozen=True)
class Step:
    """A step as its rule declares it.

    wildcard: `recording`, `robot`, or empty; of: the recordings or arms that it is run for.
    """

    name: str
    wildcard: str
    of: frozenset[str]
    input: Values
    output: Values
    params: Values
    log: Values

    def filled(self, kind: str, of: str = "") -> Names:
        """Return files or settings (`input`, `output`, `params`, `log`) for a recording or arm."""
        wildcards = {self.wildcard: of} if self.wildcard else {}
        return Names({k: filled(v, wildcards) for k, v in getattr(self, kind).items()})

    def files(self, kind: str, of: str = "") -> list[str]:
        """Return the files of a kind for a recording or arm, without their names."""
        return paths(self.filled(kind, of))

    def job(self, of: str) -> Job:
        """Return the job for a recording or arm."""
        read, written, settings = (self.filled(kind, of) for kind in ("input", "output", "params"))
        return Job(self.name, read, written, settings, **self.filled("log", of))


def filled(value: Any, wildcards: Mapping[str, str]) -> Any:
    """Return what a rule declares, for some wildcards."""
    if callable(value):
        return value(SimpleNamespace(**wildcards))
    if isinstance(value, list):
        return [filled(item, wildcards) for item in value]
    if not isinstance(value, str):
        return value
    for name, of in wildcards.items():
        value = value.replace(f"{{{name}}}", of)
    return value


@dataclass(frozen=True, eq=False)
class Batches:
    """The steps of each recording, in levels and batches.

    results: the study's folder; steps: those of each recording; of_arms: those of each arm;
    samples: a recording of each kind, whose inputs show what waits for what; recordings: all, those
    of an arm after one another.
    """

    results: str
    steps: dict[str, Step]
    of_arms: dict[str, Step]
    samples: list[str]
    recordings: list[str]
    known_levels: dict[str, int] = field(default_factory=dict)

    @cached_property
    def makers(self) -> dict[str, str]:
        """The step that writes a file of a recording, by the file's name."""
        return {
            file.rpartition("/")[2]: step.name
            for step in self.steps.values()
            for file in paths(step.output)
        }

    @cached_property
    def arm_inputs(self) -> dict[str, list[str]]:
        """What the step reads that writes a file of an arm, by this file."""
        return {
            file: step.files("input", arm)
            for step in self.of_arms.values()
            for arm in step.of
            for file in step.files("output", arm)
        }

    def maker(self, path: str) -> tuple[str, str] | None:
        """Return the step of a recording that writes a file, and the recording."""
        match path.removeprefix(f"{self.results}/").split("/"):
            case ["recordings", recording, file] if file in self.makers:
                return self.makers[file], recording
            case ["logs" | "benchmarks", step, file] if step in self.steps:
                return step, file.rpartition(".")[0]
        return None

    def level(self, step: str) -> int:
        """Return how often a recording waits for others before a step."""
        if step not in self.known_levels:
            levels = [
                self.level_of_file(file, recording)
                for recording in self.samples
                for file in self.steps[step].files("input", recording)
            ]
            self.known_levels[step] = max(levels, default=0)
        return self.known_levels[step]

    def level_of_file(self, path: str, reader: str = "") -> int:
        """Return how often recordings wait for each other before the reader has a file."""
        if made := self.maker(path):
            step, recording = made
            return self.level(step) + (recording != reader)
        return max(map(self.level_of_file, self.arm_inputs.get(path, [])), default=0)

    def level_of_arm(self, step: str) -> int:
        """Return how often recordings wait for each other before a step of an arm has run."""
        of = self.of_arms[step]
        return max(self.level_of_file(file) for arm in of.of for file in of.files("output", arm))

    @cached_property
    def levels(self) -> list[list[Step]]:
        """The steps of each level, each after those of the same recording that it reads from."""
        order = TopologicalSorter[str]()
        for name, step in self.steps.items():
            read = ((file, one) for one in self.samples for file in step.files("input", one))
            made = ((self.maker(file), sample) for file, sample in read)
            order.add(name, *(maker[0] for maker, of in made if maker and maker[1] == of))
        found: list[list[Step]] = []
        for name in order.static_order():
            found += [[] for _ in range(len(found), self.level(name) + 1)]
            found[self.level(name)].append(self.steps[name])
        return found

    @cached_property
    def batches(self) -> dict[str, list[str]]:
        """The recordings of each batch."""
        return divided(self.recordings)

    @cached_property
    def batch_of(self) -> dict[str, str]:
        """The batch of each recording."""
        return {name: batch for batch, names in self.batches.items() for name in names}

    def stamp(self, level: int, batch: str) -> str:
        """Return the file that is written when a batch has passed a level."""
        return f"{self.results}/{STAMPS}/{level}/{batch}.json"

    def stamped(self, files: list[str]) -> list[str]:
        """Return files, with stamps in place of those that are made in batches."""
        return [*dict.fromkeys(map(self.stamp_or_file, files))]

    def stamp_or_file(self, path: str) -> str:
        """Return a file, or the stamp of the batch that makes it."""
        if made := self.maker(path):
            step, recording = made
            return self.stamp(self.level(step), self.batch_of[recording])
        return path

    def steps_of(self, level: int, batch: str) -> Iterator[tuple[str, list[Step]]]:
        """Yield the recordings of a batch, each with its steps of a level, in their order."""
        for recording in self.batches[batch]:
            yield recording, [step for step in self.levels[level] if recording in step.of]

    def files(self, kind: str, level: int, batch: str) -> Iterator[str]:
        """Yield the files of a kind (`input`, `output`) of all steps of a batch at a level."""
        for recording, steps in self.steps_of(level, batch):
            for step in steps:
                yield from step.files(kind, recording)

    def chains(self, level: int, batch: str) -> Iterator[tuple[str, list[Job]]]:
        """Yield the recordings of a batch, each with its jobs of a level, in their order."""
        for recording, steps in self.steps_of(level, batch):
            yield recording, [step.job(recording) for step in steps]

    def needs(self, level: int, batch: str) -> list[str]:
        """Return what a batch reads at a level: files, and stamps of other levels and batches."""
        before = [self.stamp(level - 1, batch)] if level else []
        files = self.stamped([*self.files("input", level, batch)])
        own = self.stamp(level, batch)
        return [file for file in dict.fromkeys(before + files) if file != own]

    def settings(self, level: int, batch: str) -> str:
        """Return a checksum of the settings of a batch's steps, that of their code among them."""
        each = self.steps_of(level, batch)
        stated = [[name, [step.filled("params", name) for step in steps]] for name, steps in each]
        return hashlib.sha256(json.dumps(stated).encode()).hexdigest()[:16]

    def forget_incomplete(self) -> None:
        """Delete the stamps of batches of which a file is missing, so that it is made again, and of
        those that are no more: others have changed their recordings since.
        """
        places = [(level, batch) for level in range(len(self.levels)) for batch in self.batches]
        known = {self.stamp(*place): place for place in places}
        for stamp in Path(self.results, STAMPS).glob("*/*.json"):
            of = known.get(str(stamp))
            if of is None or not self.is_complete(*of):
                stamp.unlink()

    def is_complete(self, level: int, batch: str) -> bool:
        """Return whether all files of a batch at a level exist, but of what was left out."""
        absent = left_out([self.stamp(level, batch)])
        files = self.files("output", level, batch)
        return all(os.path.exists(file) or name_of(file, absent) for file in files)

    def left_out(self) -> dict[str, str]:
        """Return the recordings that were left out, each with the reason."""
        return left_out(self.stamp(0, batch) for batch in self.batches)


def divided(names: Sequence[str]) -> dict[str, list[str]]:
    """Return names in batches of successive ones, each called by its first.

    A batch begins at a name whose checksum is the smallest among its neighbours. Another name
    therefore changes only the batches around it, and batches are of similar size.
    """
    marks = [hashlib.sha256(name.encode()).digest() for name in names]
    reach = 1 << max(len(names) // (2 * NUMBER), 1).bit_length() - 1  # seldom another one
    found: dict[str, list[str]] = {}
    for place, name in enumerate(names):
        if not place or marks[place] == min(marks[max(0, place - reach) : place + reach + 1]):
            batch = found[name] = []
        batch.append(name)
    return found
