"""Values of JSON and YAML that are none of those expected, put anywhere into a file."""

import copy
import math
import random
from typing import Any

VALUES = (None, True, "", "x", "\x1b[31m\n", "../x", "é", "0", [], {}, [1, 2], {"a": 1}, [[]])
VALUES += (0, -1, 1, 10**30, 1e-300, 1e300, math.nan, math.inf, -math.inf)


def other_value(whole: Any, draw: random.Random) -> Any:
    """Return a copy in which a part, of all levels alike, is lost, repeated or another value."""
    whole = copy.deepcopy(whole)
    part, level = whole, draw.randint(1, 6)
    while True:
        key = draw.choice([*part] if isinstance(part, dict) else range(len(part)))
        level -= 1
        inner = part[key]
        if level == 0 or not isinstance(inner, dict | list) or not inner:
            break
        part = inner
    match draw.choice(["lost", "more", "other", "other", "other"]):
        case "lost":
            del part[key]
        case "more" if isinstance(part, list):
            part.insert(key, copy.deepcopy(part[key]))
        case _:
            part[key] = draw.choice(VALUES)
    return whole
