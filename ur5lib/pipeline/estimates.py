"""The estimates of the contact wrench, by their names in tables, as a report calls them."""

PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
NEW = {
    "Fmap": "F̂ᵐᵃᵖ",
    "least_squares": "least squares",
    "observer": "observer",
    "repeat": "repeat-aware",
}
ESTIMATES = PUBLISHED | NEW
GATED = [name for name in NEW if name != "least_squares"]  # with odds of contact of their own
