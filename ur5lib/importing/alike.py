"""Files of one form and arm, which one driver wrote: their efforts have one channel and unit."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ur5lib.importing.account import Names
from ur5lib.importing.contents import Factors, Precedent
from ur5lib.importing.efforts import UNITS_BY_CHANNEL, as_amperes
from ur5lib.importing.identity import UNDESCRIBED_ARM
from ur5lib.importing.parted_runs import PartedRun
from ur5lib.importing.proposal import Proposal

Source = Path | PartedRun
EFFORTS = (*UNITS_BY_CHANNEL, "actual_torque_less_gravity")
SAME_FACTOR = 2e-3  # relative difference of a driver's constants by two files


@dataclass(frozen=True)
class FormOfFile:
    """How a file was read: its columns; its arm; channel and factors of its efforts by their names;
    the factors that make whole milliamperes of efforts; and how many rows it has.
    """

    name: str
    columns: frozenset[Names]
    arm: str
    efforts: Mapping[Names, tuple[str, Factors]]
    amperes: Mapping[Names, Factors]
    rows: int

    def supports(self, other: "FormOfFile") -> bool:
        """Return whether a file is read like another, or has whole milliamperes by its factors."""
        return all(
            _same(self.efforts.get(names), told) or _same(("", self.amperes.get(names, ())), told)
            for names, told in other.efforts.items()
        )


def _same(one: tuple[str, Factors] | None, other: tuple[str, Factors]) -> bool:
    """Return whether an effort is read alike; channel: "" for any, of factors of any sign."""
    if one is None or len(one[1]) != len(other[1]) or (one[0] or other[0]) != other[0]:
        return False
    factors = one[1] if one[0] else np.abs(one[1])
    return bool(np.allclose(factors, other[1] if one[0] else np.abs(other[1]), rtol=SAME_FACTOR))


def form_of(proposal: Proposal) -> FormOfFile:
    """Return how a file was read."""
    file, chosen = proposal.contents, proposal.channels.items()
    efforts = {b[0].names: (name, b[0].all_factors()) for name, b in chosen if name in EFFORTS}
    raw = [b for b in file.blocks if b.meaning() in ("effort", *EFFORTS) or b.is_nameless()]
    amperes = {b.names: divided.factors for b in raw if (divided := as_amperes(b)) is not b}
    columns = frozenset(block.names for block in file.blocks + file.silent)
    return FormOfFile(
        file.path.name, columns, proposal.arm, efforts, amperes, len(proposal.moving.time)
    )


def precedents(
    forms: Mapping[Source, FormOfFile],
) -> Iterator[tuple[Source, Precedent]]:
    """Yield the files to be read anew, like the one that most files of their form and arm support.

    A file of which nothing tells the arm is of the only one of its form.
    """
    of_form = defaultdict[frozenset[Names], list[Source]](list)
    for key, form in forms.items():
        of_form[form.columns].append(key)
    for keys in of_form.values():
        arms = {forms[key].arm for key in keys} - {UNDESCRIBED_ARM}
        for arm in arms:
            same = [k for k in keys if forms[k].arm == arm or len(arms) == 1]
            yield from _like_the_most_supported({key: forms[key] for key in same}, arm)


def _like_the_most_supported(
    forms: Mapping[Source, FormOfFile], arm: str
) -> Iterator[tuple[Source, Precedent]]:
    told: Sequence[FormOfFile] = [one for one in forms.values() if one.arm == arm and one.efforts]
    if not told:
        return
    best = max(told, key=lambda one: (sum(f.supports(one) for f in forms.values()), one.rows))
    for key, form in forms.items():
        own = {names: form.efforts.get(names) for names in best.efforts}
        if form.arm != arm or not all(_same(own[n], told) for n, told in best.efforts.items()):
            yield key, Precedent(best.name, arm, best.efforts, form.supports(best))
