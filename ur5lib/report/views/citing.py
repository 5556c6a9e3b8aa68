"""The methods in two paragraphs with their references, to read and to copy into a paper."""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from ur5lib import __version__
from ur5lib.report.page.document import Code
from ur5lib.report.page.formats import day
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results

PARAGRAPHS = ("methods.model", "methods.force")


class Reference(NamedTuple):
    """A published work."""

    authors: tuple[str, ...]
    title: str
    where: str
    year: int


REFERENCES = {
    "atkeson1986": Reference(
        ("C. G. Atkeson", "C. H. An", "J. M. Hollerbach"),
        "Estimation of inertial parameters of manipulator loads and links",
        "International Journal of Robotics Research 5(3)",
        1986,
    ),
    "luh1980": Reference(
        ("J. Y. S. Luh", "M. W. Walker", "R. P. C. Paul"),
        "On-line computational scheme for mechanical manipulators",
        "Journal of Dynamic Systems, Measurement, and Control 102(2)",
        1980,
    ),
    "rabiner1989": Reference(
        ("L. R. Rabiner",),
        "A tutorial on hidden Markov models and selected applications in speech recognition",
        "Proceedings of the IEEE 77(2)",
        1989,
    ),
    "rauch1965": Reference(
        ("H. E. Rauch", "F. Tung", "C. T. Striebel"),
        "Maximum likelihood estimates of linear dynamic systems",
        "AIAA Journal 3(8)",
        1965,
    ),
    "wensing2018": Reference(
        ("P. M. Wensing", "S. Kim", "J.-J. E. Slotine"),
        "Linear matrix inequalities for physically consistent inertial parameter identification",
        "IEEE Robotics and Automation Letters 3(1)",
        2018,
    ),
}


def methods(results: Results) -> Iterator[str]:
    """Return the two paragraphs, with authors and years."""
    for name in PARAGRAPHS:
        yield _paragraph(name, results, lambda key: f"({_short(REFERENCES[key])})")


def references(results: Results) -> Iterator[str]:
    """Return the references, then how this analysis is cited."""
    works = {**REFERENCES, "ur5lib": itself(results)}
    for work in works.values():
        yield f"{', '.join(work.authors)}: {work.title}. {work.where}, {work.year}."


def itself(results: Results) -> Reference:
    """Return the reference of this analysis: its software, version and study."""
    date = analysed_on(results)
    where = f"commit {results.commit}, study “{results.study['study']}”"
    where += f", analysed on {day(date)}" if date else ""
    title = f"ur5lib {__version__}: dynamics, friction and contact force of robot arms"
    return Reference(("The ur5lib developers",), title, where, int(date[:4] or 0))


def analysed_on(results: Results) -> str:
    """Return the date on which the last step ended (ISO), empty where no step has a time."""
    times = results.tables.get("run_times")
    return str(times["last_end"].max())[:10] if times is not None and len(times) else ""


def to_copy(results: Results) -> Iterator[Code]:
    """Return the paragraphs as Markdown and LaTeX, and the references as BibTeX, folded."""
    works = {**REFERENCES, "ur5lib": itself(results)}
    texts = {
        "Methods as Markdown": _joined(results, lambda key: f"[@{key}]"),
        "Methods as LaTeX": re.sub(
            r"([%&#_])", r"\\\1", _joined(results, lambda key: f"\\cite{{{key}}}")
        ),
        "References as BibTeX": "\n".join(_bibtex(key, work) for key, work in works.items()),
    }
    return (Code(text, folded=name) for name, text in texts.items())


def _joined(results: Results, cite: Callable[[str], str]) -> str:
    return "\n\n".join(_paragraph(name, results, cite) for name in PARAGRAPHS)


def _paragraph(name: str, results: Results, cite: Callable[[str], str]) -> str:
    return say(name, cite=cite, itself=itself(results))


def _short(work: Reference) -> str:
    """Return authors and year: Luh et al. 1980."""
    surname = work.authors[0].split()[-1]
    return f"{surname}{' et al.' if len(work.authors) > 1 else ''} {work.year}"


def _bibtex(key: str, work: Reference) -> str:
    kind, place = ("misc", "note") if key == "ur5lib" else ("article", "journal")
    fields = {"author": " and ".join(work.authors), "title": work.title, place: work.where}
    lines = [f"  {name} = {{{text}}}," for name, text in fields.items()]
    return "\n".join([f"@{kind}{{{key},", *lines, f"  year = {{{work.year}}},", "}"])
