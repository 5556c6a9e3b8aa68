"""The catalogue of published data sets: `catalogue.yaml`."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from pydantic import Field

from ur5lib.strict import Strict, read_yaml

CATALOGUE_FOLDER = Path(__file__).parent
UNTRIED_NOTE = (
    "None of these downloads has been tried yet. Every file with a known checksum is verified: a "
    "wrong one is refused."
)


class Dataset(Strict):
    """A published data set.

    holds: its contents; good_for: its use; address: its page; archive: URL of a zip file with its
    files; record: URL of its record at Zenodo; leave_out: unneeded files of the record; study: the
    study file that analyses it; checksums: SHA-256 of the archive's files by name; unverified:
    number of further recordings in the archive for which no SHA-256 is listed.
    """

    holds: str
    good_for: str
    licence: str
    address: str
    archive: str | None = None
    record: str | None = None
    leave_out: list[str] = Field(default_factory=list)
    study: str | None = None
    checksums: dict[str, str] = Field(default_factory=dict)
    unverified: int = 0


@cache
def catalogue() -> dict[str, Dataset]:
    """Return the data sets by name."""
    entries = read_yaml(CATALOGUE_FOLDER / "catalogue.yaml")
    return {name: _with_checksums(name, Dataset(**entry)) for name, entry in entries.items()}


def listing() -> Iterator[str]:
    """Yield lines about each data set: contents, use, licence, address, files and study."""
    for name, dataset in catalogue().items():
        yield f"{name}: {dataset.holds}"
        yield f"  good for  {dataset.good_for}"
        yield f"  licence   {dataset.licence}"
        yield f"  address   {dataset.address}"
        yield f"  files     {_how_verified(dataset)}"
        yield f"  study     {dataset.study or 'none; `ur5 import` proposes the entries'}"
    yield UNTRIED_NOTE


def _with_checksums(name: str, dataset: Dataset) -> Dataset:
    listed = CATALOGUE_FOLDER / "checksums" / f"{name}.sha256"
    if not listed.exists():
        return dataset
    lines = (line.split(maxsplit=1) for line in listed.read_text(encoding="utf-8").splitlines())
    checksums = {file: checksum for checksum, file in lines}
    return dataset.model_copy(update={"checksums": checksums})


def _how_verified(dataset: Dataset) -> str:
    by_hand = "" if dataset.archive else "to be downloaded by hand"
    if dataset.checksums:
        more = f"; {dataset.unverified} others beside them, not verified"
        listed = f"{len(dataset.checksums)}, verified by SHA-256" + more * (dataset.unverified > 0)
        return ", ".join(filter(None, [listed, by_hand]))
    return "verified by the MD5 of the record" if dataset.record else by_hand
