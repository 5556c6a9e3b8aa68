"""A lab's requirements on every recording in a file, written from good ones, to check others."""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import yaml
from pydantic import Field, ValidationError

from ur5lib.channels import RECORDED_CHANNELS, columns, joint_count
from ur5lib.errors import InputError
from ur5lib.recordings.formats import read_recording
from ur5lib.recordings.plausibility import is_silent
from ur5lib.records.codes import Found
from ur5lib.records.quality import Device, Finding, Quality
from ur5lib.strict import Strict, explain
from ur5lib.study.model import Recording, Study
from ur5lib.study.reading import read_plain
from ur5lib.tables import write_new_text

MARGIN = 0.1  # other recordings may be shorter or slower than the good ones by this share
FEW_MISSING = 0.01  # share of missing values that a written contract always allows
Role = Literal["fit", "validate", "contact"]


@dataclass(frozen=True)
class Recorded:
    """What a device recorded: length [s], mean rate [Hz], longest gap [s], by channel the share of
    missing values, and the channels that are no part of another, as `ft_f` is of `ft`.
    """

    duration: float
    rate: float
    gap: float
    missing: dict[str, float]
    channels: list[str]


class Stream(Strict):
    """What a contract requires of a device; channels have their names in a study."""

    rate_hz: float = Field(gt=0, description="least mean rate of its samples")
    gap_s: float = Field(gt=0, description="longest time between two samples")
    missing_share: float = Field(0.0, ge=0, le=1, description="most missing values of a channel")
    channels: list[str] = Field(description="channels that must be there")


class Contract(Strict):
    """What every recording of a study must have, as a lab states it in a file."""

    contract: str = Field(description="name of the contract")
    robots: list[str] = Field([], description="arms that they may be of; default: any")
    recordings: dict[Role, int] = Field({}, description="least number of recordings by role")
    duration_s: float = Field(0.0, ge=0, description="least length of a recording in motion")
    devices: dict[Device, Stream] = Field(description="what is wanted of each device")

    def held_against(self, recording: Recording, quality: Quality) -> Quality:
        """Return the quality of a recording with violations of the contract as errors.

        Postures at rest have neither length nor rate; an unreadable recording keeps its quality.
        """
        if recording.at_rest or any(one.code == Found.UNUSABLE for one in quality.findings):
            return quality
        broken = [*self._of_entry(recording), *self._of_devices(recorded(recording))]
        return replace(quality, findings=[*broken, *quality.findings])

    def lacking(self, study: Study) -> Iterator[str]:
        """Yield a sentence for each role with too few recordings in a study."""
        counts = Counter(one.role for one in study.recordings)
        for role, least in self.recordings.items():
            if counts[role] < least:
                yield f"recordings with the role {role}: {counts[role]}; wanted: {least} at least"

    def _of_entry(self, recording: Recording) -> Iterator[Finding]:
        arm = recording.arm.known_as
        if self.robots and arm not in self.robots:
            yield _broken("robot", "robot", arm, " or ".join(self.robots))

    def _of_devices(self, found: Mapping[Device, Recorded]) -> Iterator[Finding]:
        if (lasts := found["robot"].duration) < self.duration_s:
            yield _broken("robot", "length", f"{lasts:.4g} s", f"{self.duration_s:g} s at least")
        for device, wanted in self.devices.items():
            if device not in found:
                yield _broken(device, device, "no recording", "one")
            else:
                yield from _compared(device, found[device], wanted)


def recorded(recording: Recording) -> dict[Device, Recorded]:
    """Return by device the properties of its recorded samples, before any repair.

    Raises InputError if the recording cannot be read.
    """
    raw = read_recording(recording)
    tables = {"robot": raw.robot.table} | {d: one.table for d, one in raw.sensors.items()}
    return {device: _recorded(table) for device, table in tables.items()}  # type: ignore[misc]


def _recorded(table: pd.DataFrame) -> Recorded:
    time = table["time"].to_numpy(float)
    steps = np.diff(time[np.isfinite(time)])
    steps = steps[steps > 0]
    there = {*table.columns} - {"time"}
    every = {name: {*columns(name, joint_count(there))} for name in RECORDED_CHANNELS}
    parts = {name: own for name, own in every.items() if own <= there}
    missing = {
        name: float(table[[*own]].isna().mean().max())
        for name, own in parts.items()
        if not is_silent(table[[*own]].to_numpy(float))
    }
    whole = [name for name in missing if not any(parts[name] < parts[n] for n in missing)]
    duration = float(steps.sum())
    rate, gap = (len(steps) / duration, float(steps.max())) if len(steps) else (math.nan, math.inf)
    return Recorded(duration, rate, gap, missing, whole)


def _compared(device: Device, found: Recorded, wanted: Stream) -> Iterator[Finding]:
    if not found.rate >= wanted.rate_hz:
        yield _broken(device, "rate", f"{found.rate:.4g} Hz", f"{wanted.rate_hz:g} Hz at least")
    if not found.gap <= wanted.gap_s:
        yield _broken(device, "gap", f"{found.gap:.3g} s", f"{wanted.gap_s:g} s at most")
    for name in wanted.channels:
        if name not in found.missing:
            yield _broken(device, name, "not recorded", "recorded")
        elif found.missing[name] > wanted.missing_share:
            share = f"missing in {found.missing[name]:.2%} of the rows"
            yield _broken(device, name, share, f"in {wanted.missing_share:.2%} at most")


def _broken(device: Device, place: str, found: str, wanted: str) -> Finding:
    return Finding(device, Found.CONTRACT, "error", 1, f"{place}: {found}; wanted: {wanted}", place)


def read_contract(path: Path) -> Contract:
    """Return the contract of a file. Raises InputError with a line for each mistake."""
    try:
        return Contract.model_validate(read_plain(path))
    except ValidationError as error:
        schema = Contract.model_json_schema()
        mistakes = (explain(one, schema) for one in error.errors())
        raise InputError("\n".join(f"{path}: {mistake}" for mistake in mistakes)) from error


def write_contract(study: Study, named: Sequence[str], path: Path) -> None:
    """Write the common properties of a study's good recordings as a contract, with MARGIN.

    named: the good ones, empty for all. Raises InputError if the file exists.
    """
    if path.exists():
        raise InputError(
            f"{path} exists; hold recordings against it by --contract, or name another"
        )
    good = [r for r in study.recordings if not r.at_rest and (not named or r.name in named)]
    found = [recorded(one) for one in good]
    if not found:
        raise InputError(f"{path} is not written: no recording in motion tells rates and channels")
    devices = [device for device in found[0] if all(device in own for own in found)]
    gap = study.settings.frames.max_gap_s  # shorter ones are filled
    contract = Contract(
        contract=path.stem,
        robots=sorted({one.arm.known_as for one in good}),
        recordings=dict.fromkeys((one.role for one in good), 1),
        duration_s=_digits((1 - MARGIN) * min(own["robot"].duration for own in found)),
        devices={device: _wanted([own[device] for own in found], gap) for device in devices},
    )
    plain = contract.model_dump(mode="json", exclude_defaults=True)
    head = "# what every recording must have: ur5 check <study> --contract <this file>\n"
    write_new_text(head + yaml.safe_dump(plain, sort_keys=False, width=100), path)


def _wanted(found: Sequence[Recorded], gap: float) -> Stream:
    common = [name for name in found[0].channels if all(name in one.channels for one in found)]
    missing = max(share for one in found for share in one.missing.values())
    return Stream(
        rate_hz=_digits((1 - MARGIN) * min(one.rate for one in found)),
        gap_s=_digits(max([gap, *((1 + MARGIN) * one.gap for one in found)])),
        missing_share=_digits(min(1.0, max(FEW_MISSING, (1 + MARGIN) * missing))),
        channels=common,
    )


def _digits(value: float) -> float:
    return float(f"{value:.3g}")


def contract_schema() -> str:
    """Return the JSON schema of a contract, as committed in workflow/contract.schema.json."""
    return json.dumps(Contract.model_json_schema(), indent=2) + "\n"
