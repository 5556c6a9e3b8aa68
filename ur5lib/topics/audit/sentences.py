"""The verdicts on the sensor in an arm's wrist in sentences, as `ur5 audit` prints them."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.records.phrases import number
from ur5lib.report.stated import with_error
from ur5lib.topics.audit.report import is_to_declare

JUDGED = {  # by quantity: its name in sentences, and the limit of a right value
    "scale": ("the scale", "5 %"),
    "drift": ("the drift", "1 N/min"),
    "shift": ("the shift by a contact", "1 N"),
}
AuditRows = dict[str, pd.DataFrame]
"""The rows of audit.csv of one recording by quantity, each by component."""


def verdicts(rows: pd.DataFrame) -> Iterator[str]:
    """Yield sentences about one recording's sensor, from its rows of audit.csv."""
    words = rows.astype({"component": object, "verdict": object})  # also where all are empty
    filled = words.fillna({"component": "", "verdict": ""}).set_index("component")
    audit = dict([*filled.groupby("quantity")])
    if len(filled) == 1:
        yield (
            f"{number(filled['value'].iloc[0], '.1f')} s without contact, and of the controller's "
            "force also in slow motion, are too few to judge the sensor: record ten or more in "
            "which nothing touches the tool, the flange turning slowly to different sides"
        )
        return
    if "mass" in audit:
        yield from _sensor(audit)
    if "zero" in audit:
        yield from _controllers(audit["zero"], audit["left_mass"].loc[""])


def _sensor(audit: AuditRows) -> Iterator[str]:
    """Yield sentences about the raw reading, axis by axis and as a whole."""
    for axis in "xyz":
        components = {"scale": axis, "drift": f"F{axis}", "shift": f"F{axis}"}
        rows = {name: audit[name].loc[part] for name, part in components.items() if name in audit}
        yield f"along {axis}, {'; '.join(_judged(name, row) for name, row in rows.items())}"
    if "scale" not in audit:
        yield "its scale is unknown without a declared payload that agrees with it"
    if "shift" not in audit:
        yield (
            "its shift by a contact is unknown without two contacts and a free second around each"
        )
    yield _turn(audit["turn"])
    yield from _payload(audit)


def _turn(turn: pd.DataFrame) -> str:
    """Return the verdict on the turn of the sensor's axes against frame 6, in a sentence."""
    verdicts, vector = {*turn["verdict"]}, _vector(turn["value"])
    if "unknown" in verdicts:
        return "the turn of its axes against frame 6 is undetermined by these orientations"
    if "wrong" not in verdicts:
        return f"its axes are turned against frame 6 as declared, by ({vector})°"
    size = float((turn["value"] ** 2).sum() ** 0.5)
    return (
        f"its axes are turned by {size:.1f}° against frame 6, by the rotation vector ({vector})°: "
        f"declare override: {{mounting: {{force_sensor_turn_deg: [{vector}]}}}} in robot"
    )


def _judged(name: str, row: pd.Series) -> str:
    """Return the verdict on one quantity along one axis, in a sentence."""
    word, limit = JUDGED[name]
    judged = {
        "right": f"right within {limit}",
        "wrong": f"wrong by more than {limit}",
        "unknown": "undetermined",
    }
    return f"{word} is {_with_error(row)}, {judged[row.verdict]}"


def _payload(audit: AuditRows) -> Iterator[str]:
    """Yield the mass on the sensor and the declared mass, the command that declares the former, and
    the mass by the currents.
    """
    mass = audit["mass"].loc[""]
    declared = "none is" if pd.isna(mass.expected) else f"{mass.expected:g} kg are"
    carries = f"the sensor carries {_with_error(mass)}; {declared} declared"
    if is_to_declare(audit):
        place = ", ".join(f"{value:.3f}" for value in audit["center_of_mass"]["value"])
        yield f"{carries}: set_payload({number(mass.value, '.3f')}, [{place}])"
    else:
        yield carries
    if "mass_by_currents" in audit:
        own = audit["mass_by_currents"].loc[""]
        yield f"the motors show {number(own.low, '.2f')} to {number(own.high, '.2f')} kg (95 %)"


def _controllers(zero: pd.DataFrame, remaining: pd.Series) -> Iterator[str]:
    """Yield sentences about the controller's force without contact."""
    if "unknown" in {*zero["verdict"]}:
        yield (
            "what actual_TCP_force reads when nothing touches the arm, and the mass that it still "
            "contains, are undetermined: turn the flange to different sides without contact"
        )
    else:
        force = _vector(zero["value"][:3])
        reads = f"when nothing touches the arm, actual_TCP_force reads ({force}) N"
        yield f"{reads}: call zero_ftsensor() then" if "wrong" in {*zero["verdict"]} else reads
    if remaining.verdict == "wrong":
        yield (
            "the controller's actual_TCP_force varies as if it still contained "
            f"{_with_error(remaining)}: the configured payload is off by this amount, or the "
            "sensor's scale or axes are wrong"
        )


def _vector(values: pd.Series) -> str:
    return ", ".join(f"{value:.1f}" for value in values)


def _with_error(row: pd.Series) -> str:
    """Return a value with its standard error and its unit, as text."""
    unit = "" if row.unit == "1" else f" {row.unit}"
    return f"{with_error(row.value, row.std_error)}{unit}"
