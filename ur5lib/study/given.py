"""The settings of a study that each step of the chain receives, the same from rules and in
memory.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from ur5lib.study.selection import Selection

Given = Callable[[Selection, str], Any]  # arguments: selection, name of a recording or an arm


def given(step: str, selection: Selection, name: str) -> dict[str, Any]:
    """Return the settings of a step as plain data, by the names of its parameters.

    name: of the recording, or of the arm, that the step runs for.
    """
    return {key: of(selection, name) for key, of in STEPS[step].items()}


def design(lowpass: Any) -> list[float]:
    """Return order and cut-off [Hz] of a Butterworth filter; lowpass: a part of `lowpass` in the
    settings.
    """
    return [lowpass.order, lowpass.cutoff_hz]


def _named(_: Selection, name: str) -> str:
    return name


def _entry(key: str, selection: Selection, name: str) -> Any:
    return getattr(selection.entries[name], key)


def _arm(key: str, selection: Selection, name: str) -> Any:
    return getattr(selection.study.arms()[name], key)


def _lowpass(of: str, selection: Selection, _: str) -> list[float]:
    return design(getattr(selection.study.settings.lowpass, of))


def _cutoffs_hz(selection: Selection, _: str) -> dict[str, float]:
    return selection.study.settings.lowpass.cutoffs_hz()


def _cutoff_hz(selection: Selection, _: str) -> float:
    return selection.study.settings.lowpass.currents.cutoff_hz


def _gravities(selection: Selection, robot: str) -> dict[str, list[float] | None]:
    return selection.gravities(selection.of_arm(robot, "fit"))


def _dates(selection: Selection, robot: str) -> dict[str, str]:
    return {name: selection.date(name) for name in selection.of_arm(robot, "fit")}


def _chains(selection: Selection, robot: str) -> dict[str, list[str]]:
    chains = {name: selection.before(name) for name in selection.of_arm(robot, "fit")}
    return {name: chain for name, chain in chains.items() if chain}


LOADED: Mapping[str, Given] = {
    "gravity": Selection.gravity,
    "payload": Selection.payload,
    "tcp": Selection.tcp,
    "accepted": Selection.accepted,
}
OF_CURRENTS: Given = partial(_lowpass, "currents")
STEPS: Mapping[str, Mapping[str, Given]] = {
    "describe_arm": {
        "arm": partial(_arm, "arm"),
        "robot": _named,
        "override": lambda selection, robot: _arm("override", selection, robot) or {},
    },
    "read_recording": {
        "recording": Selection.entry_to_read,
        "max_gap_s": lambda selection, _: selection.study.settings.frames.max_gap_s,
    },
    "read_postures": {"recording": Selection.entry_to_read, **LOADED},
    "pool_drifts": {"hosts": lambda selection, _: selection.study.devices_of_hosts()},
    "align_recording": {},
    "identify_model": {
        "gravities": _gravities,
        "lowpass": partial(_lowpass, "motion"),
        "currents": OF_CURRENTS,
    },
    "compute_torques": {
        "role": partial(_entry, "role"),
        **LOADED,
        "untouched": partial(_entry, "untouched"),
        "contact_place": Selection.contact_place,
        "cutoffs_hz": _cutoffs_hz,
    },
    "fit_friction": {
        "dates": _dates,
        "accepted": Selection.accepted_of_arm,
        "chains": _chains,
        "lowpass": OF_CURRENTS,
    },
    "estimate_load": {
        "name": _named,
        "gravity": Selection.gravity,
        "chain": Selection.before,
        "lowpass": OF_CURRENTS,
    },
    "predict_currents": {
        "name": _named,
        "role": partial(_entry, "role"),
        "date": Selection.date,
        "gravity": Selection.gravity,
        "untouched": partial(_entry, "untouched"),
        "chain": Selection.before,
        "lowpass": OF_CURRENTS,
    },
    "fit_residuals": {"cutoff_hz": _cutoff_hz},
    "estimate_forces": {
        "name": _named,
        "lowpass": OF_CURRENTS,
        "contact_force_n": lambda selection, _: selection.study.settings.contact.force_n,
    },
    "set_threshold": {
        "false_alarms_per_min": lambda selection, _: selection.study.settings.alarms.false_per_min
    },
    "draw_friction": {"lowpass": OF_CURRENTS},
    "draw_models": {},
}
