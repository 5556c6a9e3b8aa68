"""The recordings of a study that a step runs for, and their settings."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

from ur5lib.strict import SNAKEMAKE_PLACEHOLDER
from ur5lib.study.model import Study
from ur5lib.study.succession import before

MAX_EXAMINED_WHOLE = 100  # of a study with up to this many recordings, all are examined
MAX_DRAWN = 40  # of an arm's contact-free recordings, trial contacts use this many
MAX_ILLUSTRATED = 4  # a section of the report has figures of this many recordings
OF_THE_STUDY = ["name", "role", "robot", "date", "gravity", "mounting", "tool", "payload"]
OF_THE_STUDY += [
    "after",
    "untouched",
    "accept",
    "simulate",
    "truth",
]  # keys that its reader ignores


@dataclass(frozen=True, eq=False)
class Selection:
    """The recordings of a study, and functions that select them and their settings for steps."""

    study: Study

    @cached_property
    def entries(self) -> dict[str, Any]:
        """The entry of each recording."""
        return {entry.name: entry for entry in self.study.recordings}

    @cached_property
    def at_rest(self) -> list[str]:
        """The recordings of postures, without time."""
        return [name for name, entry in self.entries.items() if entry.at_rest]

    @cached_property
    def recordings(self) -> dict[str, Any]:
        """The entries of the recordings in motion."""
        return {name: one for name, one in self.entries.items() if not one.at_rest}

    @cached_property
    def simulated(self) -> list[str]:
        """The recordings of the virtual test stand."""
        return [name for name, one in self.recordings.items() if getattr(one, "simulate", None)]

    def truths(self, results: str) -> dict[str, str]:
        """Return by recording the path, without suffixes, of the true values of a simulated or
        emulated recording; results: folder of the study's results.
        """
        given = {
            name: f"{one.folder}/{one.truth}"
            for name, one in self.recordings.items()
            if getattr(one, "truth", None)
        }
        return {name: f"{results}/truth/{name}" for name in self.simulated} | given

    def arm(self, recording: str) -> str:
        """Return the name of a recording's arm."""
        return str(self.entries[recording].arm.known_as)

    def of_arm(self, robot: str, *roles: str, at_rest: bool = False) -> list[str]:
        """Return an arm's recordings with one of some roles, in motion or at_rest."""
        among = self.at_rest if at_rest else self.recordings
        named = ((name, self.entries[name]) for name in among)
        return [n for n, one in named if one.role in roles and one.arm.known_as == robot]

    def drawn(self, robot: str) -> list[str]:
        """Return the contact-free recordings of an arm on which pushes are tried.

        If there are many, some are drawn by a hash of their names: an additional recording seldom
        changes the choice.
        """
        names = self.of_arm(robot, "fit", "validate")
        if not self.is_large:
            return names
        chosen = sorted(names, key=lambda name: sha256(name.encode()).digest())[:MAX_DRAWN]
        return [name for name in names if name in chosen]

    @cached_property
    def _after(self) -> dict[str, str | None]:
        return {name: one.after for name, one in self.recordings.items()}

    def before(self, *names: str) -> list[str]:
        """Return the recordings after which the named ones follow, directly or not, each chain
        oldest first.
        """
        return [*dict.fromkeys(one for name in names for one in before(name, self._after))]

    @property
    def is_large(self) -> bool:
        """Return whether the study has too many recordings to examine all."""
        return len(self.recordings) > MAX_EXAMINED_WHOLE

    @cached_property
    def illustrated(self) -> list[str]:
        """The recordings of which the report may show figures.

        The first few with contact, the first few to validate, and the first of all.
        """
        by_role = {
            role: [name for name, one in self.recordings.items() if one.role == role]
            for role in ("contact", "validate")
        }
        touched = sorted(by_role["contact"], key=lambda name: not self.has_force_sensor(name))
        few = touched[:MAX_ILLUSTRATED], by_role["validate"][:MAX_ILLUSTRATED]
        chosen = {*few[0], *few[1], *[*self.recordings][:1]}
        return [name for name in self.recordings if name in chosen]

    @cached_property
    def examined(self) -> frozenset[str]:
        """The recordings that are examined completely; no estimated force depends on the choice.

        All of a small study; of a large one, some that are drawn, and those that are shown or
        fitted to.
        """
        if not self.is_large:
            return frozenset(self.recordings)
        drawn = (name for robot in self.study.arms() for name in self.drawn(robot))
        fitted = (name for name, one in self.recordings.items() if one.role == "fit")
        return frozenset([*drawn, *self.illustrated, *fitted])

    def has_force_sensor(self, name: str) -> bool:
        """Return whether a recording has a force sensor: in its entry, or as a file."""
        stated = getattr(self.recordings[name], "force_sensor", None)
        return bool(stated) or any("force_sensor" in path for path in self.raw_files(name))

    def raw_files(self, name: str) -> list[str]:
        """Return the files that a recording's entry names; if it names none, all files of its
        folder that readers may use.
        """
        folder = Path(self.entries[name].folder)
        stated = [folder / file for file in self.entries[name].file_names()]
        if name in self.simulated:
            return [str(path) for path in stated]
        named = [part for one in stated for part in (one.glob("*") if one.is_dir() else [one])]
        files = named if stated else [*folder.glob("*"), *folder.glob("csv_files/*")]
        paths = sorted(str(path) for path in files if path.is_file())
        return [path for path in paths if not SNAKEMAKE_PLACEHOLDER.search(path)]

    def entry_to_read(self, name: str) -> dict[str, Any]:
        """Return the part of a recording's entry that the reader of its format uses."""
        exclude = dict.fromkeys(OF_THE_STUDY, True) | {"force_sensor": {"mounting"}}
        entry: dict[str, Any] = self.entries[name].model_dump(mode="json", exclude=exclude)
        return entry

    def gravity(self, name: str) -> list[float] | None:
        """Return gravity in a recording's base frame [m/s²]; None: as described for the arm."""
        gravity: Sequence[float] | None = self.entries[name].known_gravity()
        return None if gravity is None else [*gravity]

    def gravities(self, names: Iterable[str]) -> dict[str, list[float] | None]:
        """Return gravity (3,) [m/s²] in the base frames of several recordings, by name."""
        return {name: self.gravity(name) for name in names}

    def payload(self, name: str) -> dict[str, Any] | None:
        """Return the payload that the study declares for a recording."""
        payload = self.entries[name].known_payload()
        return payload.model_dump(mode="json") if payload else None

    def tcp(self, name: str) -> list[float] | None:
        """Return the tool centre point that the study declares for a recording."""
        tool = self.entries[name].known_tool()
        return [*tool.tcp] if tool and tool.tcp else None

    def contact_place(self, name: str) -> list[Any] | None:
        """Return the place of contacts that the study states, [m], and their usual distance [m]."""
        place = self.entries[name].stated_contact_place()
        return None if place is None else [[*place[0]], place[1]]

    def accepted(self, name: str) -> dict[str, str]:
        """Return the reasons for which the study overrules a recording's stop signs, by kind."""
        reasons: dict[str, str] = self.entries[name].accepted()
        return reasons

    def accepted_of_arm(self, robot: str) -> dict[str, str]:
        """Return the reasons to overrule stop signs, by kind, of all recordings that an arm is
        fitted to.
        """
        names = self.of_arm(robot, "fit") + self.of_arm(robot, "fit", at_rest=True)
        return {kind: why for name in names for kind, why in self.accepted(name).items()}

    def sensor_mounting(self, name: str) -> list[list[float] | None]:
        """Return position [m] and turn [°] of a recording's force sensor; None: as described."""
        return [stated and [*stated] for stated in self.entries[name].sensor_mounting()]

    def date(self, name: str) -> str:
        """Return the date of a recording; empty where the study gives none."""
        return str(self.recordings[name].date or "")
