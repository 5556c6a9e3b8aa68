"""Sentences about a study's results, and steps: a sentence with the command that does it."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date

from ur5lib.errors import OVERRULED_BY, printable
from ur5lib.force.estimators import LEADING
from ur5lib.records.contacts import OF_CONTACTS, Kind
from ur5lib.report.results import Results
from ur5lib.timeseries.metrics import NORMAL95

MOST_NAMED = 3  # recordings that a sentence names
# A part of a finding with fewer words is a place; with more, it says what is wrong.
MIN_CLAIM_WORDS = 4
LINE = re.compile(r"`([\w ]+: [^`]+)`")  # a quoted line of a study or a description
UNSPACED = re.compile(r"(?<=\d)%")
LOAD_BESIDE_AXIS = "0.06 0 0.05"  # m; gravity on a load there, in frame 6, loads the last joint


@dataclass(frozen=True)
class Step:
    """A step that the user may take next: a sentence, and what does it.

    command: the command, or the line of the study or of a description, that does it; empty if there
    is none.
    """

    sentence: str
    command: str = ""

    def __post_init__(self) -> None:
        """Make the words printable."""
        object.__setattr__(self, "sentence", printable(self.sentence))
        object.__setattr__(self, "command", printable(self.command))


def designing(results: Results, robot: str, load: float | None = None) -> str:
    """Return the command that designs the next recording of an arm; load: on the flange [kg]."""
    height = (results.study.get("devices") or {}).get("table_m")
    options = f" --payload {load:g} {LOAD_BESIDE_AXIS}" if load else ""
    options += f" --table {height:g}" if height else ""
    study, name = results.study.get("study", ""), "loaded" if load else "next"
    return (
        f"ur5 excite --robot {robot} --results results/{study}{options} --output raw/{study}/{name}"
    )


def capital(text: str) -> str:
    """Return a text with a capital letter."""
    return text[:1].upper() + text[1:]


def with_error(value: float, std: float) -> str:
    """Return a value ± half of its 95 % interval, rounded to one digit of that half, or to whole
    numbers; without an error, the value alone.

    std: standard error.
    """
    if not 0 < std < math.inf:
        return f"{value:.3g}"
    half = NORMAL95 * std
    digits = max(0, -math.floor(math.log10(half)))
    return f"{value:.{digits}f} ± {half:.{digits}f}"


def joints(numbers: Iterable[float]) -> str:
    """Return joint numbers in words: joint 2; joints 1, 3; joints 1 to 6."""
    known = [round(number) for number in numbers]
    in_row = len(known) > 2 and known == [*range(known[0], known[-1] + 1)]
    told = f"{known[0]} to {known[-1]}" if in_row else ", ".join(map(str, known))
    return f"joint{'s' * (len(known) > 1)} {told}"


def listed(names: Sequence[str], count: int = 0) -> str:
    """Return names in words: a; a and b; a, b and 3 others.

    count: number of all names, if `names` has only the first.
    """
    count = max(count, len(names))
    shown = [*names[: MOST_NAMED if count > MOST_NAMED else count]]
    if more := count - len(shown):
        shown.append(f"{more} other{'s' * (more > 1)}")
    return " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def quoted(names: Iterable[str], count: int = 0) -> str:
    """Return names of recordings in words, in quotation marks; count: as of `listed`."""
    return listed([f"“{name}”" for name in names], count)


def alarms_on(results: Results, recording: str) -> str:
    """Return the number of the leading estimate's alarms on a recording, but for loads, with their
    times.
    """
    kinds = [*OF_CONTACTS, Kind.FALSE]
    rows = results.rows("contacts", estimate=LEADING, recording=recording, kind=kinds)
    times = listed([f"{time:.1f}" for time in rows["peak_s"]]) if len(rows) else ""
    return f"{len(rows)} alarm{'s' * (len(rows) != 1)}{f' at {times} s' * bool(times)}"


def claim(text: str) -> str:
    """Return the part of a finding that says what is wrong, without reasons and remedy."""
    whole = text.partition("; ")[0]
    first = whole.partition(": ")[0]
    return UNSPACED.sub(" %", first if len(first.split()) >= MIN_CLAIM_WORDS else whole)


def remedy(text: str) -> str:
    """Return the part of a finding after its first semicolon, which asks for a remedy, or ""."""
    return text.partition("; ")[2].partition("; ")[0].partition(" (")[0]


def line(text: str) -> str:
    """Return the line of a study or a description that a finding proposes, "" without one."""
    found = LINE.search(text)
    return found[1] if found else ""


def overruled(text: str) -> tuple[str, str]:
    """Return the sentence of a stop sign, and the line of a study that overrules it, "" without
    one.
    """
    sign, _, after = text.partition(OVERRULED_BY)
    return sign, line(after)


def day(iso: str) -> str:
    """Return an ISO date in words."""
    known = date.fromisoformat(iso)
    return f"{known.day} {known:%B %Y}"
