"""The methods in two paragraphs with their references, to read and to copy into a paper."""

import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from ur5lib import __version__
from ur5lib.report.page.document import Code
from ur5lib.report.page.sentences import names, say
from ur5lib.report.results import Results

REFERENCE = re.compile(r"(?P<author>.*?): (?P<title>.*)\. (?P<journal>.*), (?P<year>\d*)")
ITSELF = "ur5lib"


def methods(results: Results) -> Iterator[str]:
    """Return the two paragraphs, with authors and years."""
    yield from _paragraphs(lambda key: f"({_short(names('reference')[key])})")


def references(results: Results) -> list[str]:
    """Return the references, the first of which is that of this analysis."""
    return [f"{reference}." for reference in _references(results).values()]


def to_copy(results: Results) -> Iterator[Code]:
    """Return the paragraphs as Markdown and LaTeX, and the references as BibTeX, folded."""
    latex = "\n\n".join(_paragraphs(lambda key: f"\\cite{{{key}}}"))
    yield Code("\n\n".join(_paragraphs(lambda key: f"[@{key}]")), folded="Methods as Markdown")
    yield Code(re.sub(r"([%&#_])", r"\\\1", latex), folded="Methods as LaTeX")
    entries = (_bibtex(key, reference) for key, reference in _references(results).items())
    yield Code("\n".join(entries), folded="References as BibTeX")


def analysed_on(results: Results) -> str:
    """Return the date on which the last step ended (ISO), empty where no step has a time."""
    times = results.tables.get("run_times")
    return str(times["last_end"].max())[:10] if times is not None and len(times) else ""


def _references(results: Results) -> dict[str, str]:
    known = {"study": results.study["study"], "commit": results.commit, "version": __version__}
    itself = say("methods.itself", day=analysed_on(results), **known)
    return {ITSELF: itself, **names("reference")}


def _paragraphs(cite: Callable[[str], str]) -> list[str]:
    return [say(f"methods.{part}", cite=cite, version=__version__) for part in ("model", "force")]


def _short(reference: str) -> str:
    """Return authors and year: Luh et al. 1980."""
    authors = reference.partition(":")[0].split(", ")
    return f"{authors[0].split()[-1]}{' et al.' * bool(authors[1:])} {reference[-4:]}"


def _bibtex(key: str, reference: str) -> str:
    found = REFERENCE.fullmatch(reference)
    fields = found.groupdict() if found else {"note": reference}
    fields["author"] = fields.get("author", "").replace(", ", " and ")
    lines = [f"  {name} = {{{text}}}," for name, text in fields.items()]
    return "\n".join([f"@{'misc' if key == ITSELF else 'article'}{{{key},", *lines, "}"])


class Reference(NamedTuple):
    """A paper that the methods rest on, by the key under which they cite it."""

    key: str
    author: tuple[str, ...]
    title: str
    journal: str
    year: int


CITED = (
    Reference(
        "rauch1965",
        ("H. E. Rauch", "F. Tung", "C. T. Striebel"),
        "Maximum likelihood estimates of linear dynamic systems",
        "AIAA Journal 3(8)",
        1965,
    ),
    Reference(
        "luh1980",
        ("J. Y. S. Luh", "M. W. Walker", "R. P. C. Paul"),
        "On-line computational scheme for mechanical manipulators",
        "Journal of Dynamic Systems, Measurement, and Control 102(2)",
        1980,
    ),
    Reference(
        "atkeson1986",
        ("C. G. Atkeson", "C. H. An", "J. M. Hollerbach"),
        "Estimation of inertial parameters of manipulator loads and links",
        "International Journal of Robotics Research 5(3)",
        1986,
    ),
    Reference(
        "wensing2018",
        ("P. M. Wensing", "S. Kim", "J.-J. E. Slotine"),
        "Linear matrix inequalities for physically consistent inertial parameter identification",
        "IEEE Robotics and Automation Letters 3(1)",
        2018,
    ),
    Reference(
        "rabiner1989",
        ("L. R. Rabiner",),
        "A tutorial on hidden Markov models and selected applications in speech recognition",
        "Proceedings of the IEEE 77(2)",
        1989,
    ),
)


def cited(_: Results) -> list[dict[str, Any]]:
    """Return the references of the methods."""
    return [reference._asdict() for reference in CITED]
