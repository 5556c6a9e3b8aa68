"""The estimates of the contact wrench, as the report calls them, in its order."""

PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
NEW = {
    "Fmap": "F̂ᵐᵃᵖ",
    "least_squares": "least squares",
    "observer": "observer",
    "repeat": "repeat-aware",
}
ESTIMATES = PUBLISHED | NEW
