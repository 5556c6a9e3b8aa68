"""What is wrong with the force sensor in an arm's wrist, in sentences and numbers."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import fixed, interval, number
from ur5lib.report.contents import MOST_SHOWN
from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results

NAMES = {
    "bias": "bias at the start",
    "drift": "drift",
    "turn": "turn of the axes",
    "scale": "scale",
    "mass": "mass on the sensor",
    "center_of_mass": "its centre of mass",
    "shift": "shift by a contact",
    "zero": "actual_TCP_force without contact",
    "left_mass": "mass left in actual_TCP_force",
    "mass_by_currents": "mass by the motor currents",
}
WORDS = {"scale": "the scale", "drift": "the drift", "shift": "what a contact leaves"}
LIMITS = {"scale": "5 %", "drift": "1 N/min", "shift": "1 N"}
DIGITS = {"N": 2, "N/min": 2, "Nm": 3, "Nm/min": 3, "°": 2, "1": 4, "kg": 3, "m": 4}
TELLING = 0.1  # relative error of a mass that may be declared
SHORT = "{seconds} s without contact are too few to judge the sensor: record ten or more in which \
nothing touches the tool, the flange turning to different sides"


def audited(results: Results) -> list[str]:
    """Return the first few recordings with a wrist sensor."""
    return [*map(str, results.tables["audit"]["recording"].unique())][:MOST_SHOWN]


def found(results: Results, of: str) -> Iterator[str]:
    """Yield what was found about a recording's sensor."""
    for sentence in verdicts(results.rows("audit", recording=of)):
        yield f"{sentence[0].upper()}{sentence[1:]}."


def faults(results: Results) -> Iterator[str]:
    """Yield what is wrong with wrist sensors, in a sentence for each kind of fault."""
    rows = results.rows("audit", verdict="wrong")
    for quantity, part in rows.groupby("quantity", sort=False):
        names = ", ".join(map(str, part["recording"].unique()))
        yield f"Wrist sensor: wrong {NAMES[str(quantity)]} on {names}; section “The wrist sensor”."


def values(results: Results, of: str) -> Body:
    """Return every value of a recording's sensor, with its verdict."""
    rows = results.rows("audit", recording=of)
    rows = rows[rows["quantity"] != "free_time"]
    body = [
        [
            Cell(f"{NAMES[row.quantity]} {row.component}".strip()),
            Cell(row.unit),
            number(row.value, digits := DIGITS[row.unit]),
            Cell(interval(row.low, row.high, digits)),
            number(row.expected, digits),
            Cell(row.verdict or "–"),
        ]
        for row in rows.fillna({"component": "", "verdict": ""}).itertuples()
    ]
    return Body(["quantity", "unit", "value", "95 %", "should be", "verdict"], body)


def verdicts(rows: pd.DataFrame) -> Iterator[str]:
    """Yield sentences about one recording's sensor, from its rows of audit.csv."""
    told = rows.fillna({"component": "", "verdict": ""}).set_index(["quantity", "component"])
    if len(told) == 1:
        yield SHORT.format(seconds=fixed(told["value"].iloc[0], 1))
        return
    known = told.index.get_level_values(0)
    if "mass" in known:
        yield from _sensor(told)
    yield from _controller(told)


def _sensor(told: pd.DataFrame) -> Iterator[str]:
    """Yield sentences about the raw reading, axis by axis and as a whole."""
    known = told.index.get_level_values(0)
    for axis in "xyz":
        parts = ("scale", axis), ("drift", f"F{axis}"), ("shift", f"F{axis}")
        judged = [_judged(told.loc[part], part[0]) for part in parts if part[0] in known]
        yield f"along {axis}, {'; '.join(judged)}"
    if "scale" not in known:
        yield "its scale is unknown without a declared payload that it agrees with"
    if "shift" not in known:
        yield "what a contact leaves is unknown without two contacts and a free second around each"
    yield from _turn(told)
    yield from _payload(told)


def _judged(row: pd.Series, quantity: str) -> str:
    """Return a value in words, with the verdict on it."""
    unit = "" if row.unit == "1" else f" {row.unit}"
    value = f"{WORDS[quantity]} is {_with_error(row)}{unit}"
    if row.verdict == "unknown":
        return f"{value}, which tells nothing"
    return (
        f"{value}, {'right within' if row.verdict == 'right' else 'wrong by more than'} "
        + (LIMITS[quantity])
    )


def _with_error(row: pd.Series) -> str:
    digits = DIGITS[row.unit]
    return f"{fixed(row.value, digits)} ± {fixed(row.std_error, digits)}"


def _turn(told: pd.DataFrame) -> Iterator[str]:
    turn = told.loc["turn"]
    vector = ", ".join(fixed(value, 1) for value in turn["value"])
    if (turn["verdict"] == "unknown").any():
        yield "the orientations do not tell whether its axes are turned against frame 6"
    elif (turn["verdict"] == "wrong").any():
        size = fixed(float((turn["value"] ** 2).sum() ** 0.5), 1)
        typed = vector.replace("−", "-")
        yield (
            f"its axes are turned by {size}° against frame 6, by the rotation vector ({vector})°: "
            f"declare override: {{mounting: {{force_sensor_turn_deg: [{typed}]}}}} in robot"
        )
    else:
        yield f"its axes are turned against frame 6 as declared, by ({vector})°"


def _payload(told: pd.DataFrame) -> Iterator[str]:
    """Yield the mass on the sensor beside the declared one, and how to declare it."""
    mass, center = told.loc[("mass", "")], told.loc["center_of_mass"]
    declared = "none is declared"
    if not pd.isna(mass.expected):
        declared = f"{mass.expected:.3g} kg are declared"
    sentence = f"the sensor carries {_with_error(mass)} kg; {declared}"
    certain = 0 < mass.std_error < TELLING * mass.value
    if certain and _is_other(told):
        place = ", ".join(fixed(value, 3).replace("−", "-") for value in center["value"])
        sentence += f": set_payload({mass.value:.3f}, [{place}])"
    yield sentence
    if ("mass_by_currents", "") in told.index:
        by = told.loc[("mass_by_currents", "")]
        yield f"the motor currents show {interval(by.low, by.high, 2)} kg (95 %)"


def _is_other(told: pd.DataFrame) -> bool:
    """Return whether the payload is not the declared one: none is, its place is another, or the
    sensor's scale cannot explain the difference.
    """
    known = told.index.get_level_values(0)
    return "scale" not in known or bool((told.loc["center_of_mass", "verdict"] == "wrong").any())


def _controller(told: pd.DataFrame) -> Iterator[str]:
    """Yield what is left in the controller's force when nothing touches the arm."""
    if "zero" not in told.index.get_level_values(0):
        return
    zero, left = told.loc["zero"], told.loc[("left_mass", "")]
    force = ", ".join(fixed(value, 1) for value in zero["value"][:3])
    if (zero["verdict"] == "wrong").any():
        yield (
            f"actual_TCP_force reads ({force}) N when nothing touches the arm: call "
            "zero_ftsensor() then"
        )
    else:
        yield f"actual_TCP_force reads ({force}) N when nothing touches the arm"
    if left.verdict == "wrong":
        yield (
            f"actual_TCP_force varies as if {_with_error(left)} kg were left in it: the payload is "
            "configured wrongly by that, or the sensor's scale or axes are wrong"
        )
