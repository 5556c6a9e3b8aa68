"""The estimates of the contact wrench, by their names in tables, as a report calls them."""

PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
NEW = {
    "Fmap": "F̂ᵐᵃᵖ",
    "least_squares": "least squares",
    "observer": "observer",
    "repeat": "repeat-aware",
    "static": "uncalibrated static estimate",
}
ESTIMATES = PUBLISHED | NEW
SPOKEN = ESTIMATES | {"static": f"the {NEW['static']}"}  # as in sentences
GATED = [
    name for name in NEW if name not in ("least_squares", "static")
]  # with odds of contact of their own
