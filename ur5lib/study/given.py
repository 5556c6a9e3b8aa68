"""What a study gives to steps, by the names in their declarations: settings, files, and which
recordings they read.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from ur5lib.robots.description import robot_path
from ur5lib.study.selection import Selection
from ur5lib.workspace.places import PACKAGE

Given = Callable[[Selection, str], Any]  # arguments: selection, name of a recording or an arm
GivenOfSeveral = Callable[[Selection, Sequence[str]], Any]  # selection, names of recordings


def design(lowpass: Any) -> list[float]:
    """Return order and cut-off [Hz] of a Butterworth filter; lowpass: a part of `lowpass` in the
    settings.
    """
    return [lowpass.order, lowpass.cutoff_hz]


def among(selection: Selection, which: str) -> list[str]:
    """Return the recordings in motion that a step declares by `recordings`, in their order."""
    chosen = CHOSEN[which](selection)
    return [name for name in selection.recordings if name in chosen]


def of_arm(selection: Selection, which: str, robot: str) -> list[str]:
    """Return those of an arm."""
    return [name for name in among(selection, which) if selection.arm(name) == robot]


def _with_role(*roles: str) -> Callable[[Selection], set[str]]:
    return lambda selection: {
        name for name, one in selection.recordings.items() if one.role in roles
    }


def _drawn(selection: Selection) -> set[str]:
    return {name for robot in selection.study.arms() for name in selection.drawn(robot)}


CHOSEN: Mapping[str, Callable[[Selection], Any]] = {
    "": lambda selection: selection.recordings,
    "fit": _with_role("fit"),
    "contact_free": _with_role("fit", "validate"),
    "drawn": _drawn,
    "examined": lambda selection: selection.examined,
    "illustrated": lambda selection: selection.illustrated,
}


def _named(_: Selection, name: str) -> str:
    return name


def _of_entry(key: str, selection: Selection, name: str) -> Any:
    return getattr(selection.entries[name], key)


def _of_arm(key: str, selection: Selection, robot: str) -> Any:
    return getattr(selection.study.arms()[robot], key)


def _of_settings(path: str, selection: Selection, _: str) -> Any:
    value: Any = selection.study.settings
    for key in path.split("."):
        value = getattr(value, key)
    return value


def _lowpass(of: str, selection: Selection, _: str) -> list[float]:
    return design(_of_settings(f"lowpass.{of}", selection, ""))


def _fit_settings(selection: Selection, _: str) -> dict[str, Any]:
    lowpass, friction = _lowpass("currents", selection, ""), _of_settings("friction", selection, "")
    return {"lowpass": lowpass, "terms": friction.terms, "prior": friction.prior}


def _description(selection: Selection, robot: str) -> list[str]:
    """Return the description of an arm that the library does not have."""
    path = robot_path(_of_arm("arm", selection, robot))
    return [] if path.is_relative_to(PACKAGE) else [str(path)]


def _calibration(selection: Selection, robot: str) -> list[str]:
    path = _of_arm("calibration", selection, robot)
    return [str(path)] if path else []


# A setting, or a file of the user, of a recording or of an arm
OF_STUDY: Mapping[str, Given] = {
    "bias_window_s": partial(_of_settings, "sensor.bias_window_s"),
    "contact_force_n": partial(_of_settings, "contact.force_n"),
    "cutoff_hz": partial(_of_settings, "lowpass.currents.cutoff_hz"),
    "cutoffs_hz": lambda selection, _: selection.study.settings.lowpass.cutoffs_hz(),
    "false_alarms_per_min": partial(_of_settings, "alarms.false_per_min"),
    "fit_settings": _fit_settings,
    "hosts": lambda selection, _: selection.study.devices_of_hosts(),
    "lowpass": partial(_lowpass, "currents"),
    "motion_lowpass": partial(_lowpass, "motion"),
    "accelerations_lowpass": partial(_lowpass, "accelerations"),
    "published_lowpass": partial(_lowpass, "published_forces"),
    "max_gap_s": partial(_of_settings, "frames.max_gap_s"),
    "min_singular_value": partial(_of_settings, "singularities.min_singular_value"),
    "pushed_posture": partial(_of_settings, "pushes.posture_deg"),
    "trial_pushes": partial(_of_settings, "pushes.per_arm"),
}
OF_RECORDING: Mapping[str, Given] = {
    **OF_STUDY,
    "accepted": Selection.accepted,
    "chain": Selection.before,
    "contact_place": Selection.contact_place,
    "date": Selection.date,
    "declared_payload": Selection.payload,
    "entry": Selection.entry_to_read,
    "gravity": Selection.gravity,
    "mounting": Selection.sensor_mounting,
    "name": _named,
    "role": partial(_of_entry, "role"),
    "tcp": Selection.tcp,
    "untouched": partial(_of_entry, "untouched"),
}
OF_ARM: Mapping[str, Given] = {
    **OF_STUDY,
    "accepted": Selection.accepted_of_arm,
    "override": lambda selection, robot: _of_arm("override", selection, robot) or {},
    "robot": _named,
    "type": partial(_of_arm, "arm"),
}
# Of the recordings that a step of an arm reads, by name
OF_SEVERAL: Mapping[str, GivenOfSeveral] = {
    "chains": lambda selection, names: {
        name: chain for name in names if (chain := selection.before(name))
    },
    "dates": lambda selection, names: {name: selection.date(name) for name in names},
    "gravities": Selection.gravities,
    "roles": lambda selection, names: {name: selection.entries[name].role for name in names},
}
FILES: Mapping[str, Given] = {
    "calibration_file": _calibration,
    "description": _description,
    "raw": Selection.raw_files,
    "reference": lambda selection, _: selection.study.reference or [],
}
# An output of further recordings
OF_OTHERS: Mapping[str, tuple[str, Given]] = {
    "before": ("motion", Selection.before),
    "before_fitted": (
        "motion",
        lambda selection, robot: selection.before(*of_arm(selection, "fit", robot)),
    ),
    "previous": ("motion", lambda selection, name: selection.before(name)[-1:]),
    "postures": (
        "postures",
        lambda selection, robot: selection.of_arm(robot, "fit", at_rest=True),
    ),
}


def setting(of: str, which: str, name: str) -> Given | None:
    """Return the function that gives a setting to a step; None where none has that name.

    of, which: what the step is for, and its recordings, as it declares them.
    """
    if of != "arm":
        return OF_RECORDING.get(name)
    if name in OF_SEVERAL:
        return lambda selection, robot: OF_SEVERAL[name](selection, of_arm(selection, which, robot))
    return OF_ARM.get(name)
