"""The methods in two paragraphs with their references, to read and to copy into a paper."""

from typing import Any, NamedTuple

from ur5lib.datasets.catalogue import catalogue
from ur5lib.report.results import Results


class Reference(NamedTuple):
    """A paper that the report's paragraphs on the methods cite by `key`."""

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
    """Return the references that the paragraphs on the methods cite."""
    return [reference._asdict() for reference in CITED]


def published(results: Results) -> list[dict[str, Any]]:
    """Return name and address of each published data set with files that the study read, how many
    these are, and of how many files; they are compared by SHA-256.
    """
    read = {*results.rows("files")["sha256"]}
    counts = {name: len(read & {*one.checksums.values()}) for name, one in catalogue().items()}
    return [
        {"name": name, "address": catalogue()[name].address, "count": count, "of": len(read)}
        for name, count in counts.items()
        if count
    ]
