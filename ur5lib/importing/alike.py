"""Files of one form and arm, which one driver wrote: their joints have one order, and their efforts
one channel and unit.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ur5lib.importing.account import Names
from ur5lib.importing.blocks import NAMELESS_PREFIX
from ur5lib.importing.efforts import EFFORT_MEANINGS, as_amperes
from ur5lib.importing.form_of_file import FormOfFile
from ur5lib.importing.identity import ORDER, UNDESCRIBED_ARM
from ur5lib.importing.proposal import Proposal
from ur5lib.records.account import AccountRow


def form_of(proposal: Proposal) -> FormOfFile:
    """Return how a file was read, for other files of the same form to be read alike."""
    file, chosen = proposal.contents, proposal.channels.items()
    guessed = any(r.subject == ORDER and r.evidence == "position" for r in file.account.of_file)
    efforts = {
        b[0].names: (name, b[0].all_factors()) for name, b in chosen if name in EFFORT_MEANINGS
    }
    raw = [block for block in file.blocks if block.meaning() in EFFORT_MEANINGS]
    amperes = {b.names: divided.factors for b in raw if (divided := as_amperes(b)) is not b}
    columns = frozenset(block.names for block in file.blocks + file.silent)
    rows = len(proposal.moving.time)
    told = proposal.arm, None if guessed else proposal.order, efforts, amperes
    sure = [{row.confidence for row in file.account.of_columns.get(names, ())} for names in efforts]
    proven = bool(sure) and all("proven" in own and "check" not in own for own in sure)
    return FormOfFile(file.path.name, columns, *told, rows, proven=proven)


def precedents(forms: Mapping[int, FormOfFile]) -> Iterator[tuple[int, FormOfFile]]:
    """Yield the numbers of files to be read anew, each with the form of the file that most files of
    the same columns and arm support.

    A file that shows no arm is taken for the only arm of its form; one that proves its efforts
    otherwise stays as it is. Columns without names show no form.
    """
    of_form = defaultdict[frozenset[Names], list[int]](list)
    for source, form in forms.items():
        if not any(names[0].startswith(NAMELESS_PREFIX) for names in form.columns):
            of_form[form.columns].append(source)
    for sources in of_form.values():
        arms = {forms[source].arm for source in sources} - {UNDESCRIBED_ARM}
        for arm in arms or {UNDESCRIBED_ARM}:
            same = [one for one in sources if forms[one].arm == arm or len(arms) == 1]
            told = [forms[one] for one in same if forms[one].arm == arm and forms[one].efforts]
            votes = [sum(forms[one].supports(other) for one in same) for other in told]
            ranked = sorted(zip(votes, told, strict=True), key=lambda one: (one[0], one[1].rows))
            for source in same if ranked else ():
                form, best = forms[source], ranked[-1][1]
                own = form.arm == arm and form.proven and not form.supports(best)
                if not own and (form.arm != arm or not form.is_like(best)):
                    yield source, replace(best, shown=form.supports(best))


def unlike(entry: Mapping[str, Any], others: Iterable[Mapping[str, Any]]) -> AccountRow | None:
    """Return the row to be checked if an entry has efforts in other units than another recording of
    its arm and columns in the study; None if it has not.
    """
    (form, units) = _efforts_of(entry)
    for other in others:
        its_form, its_units = _efforts_of(other)
        if form == its_form and units != its_units:
            apart = f"{other['name']} of this study has {its_units}, and one driver has one unit"
            return AccountRow("efforts", units, "numbers", "check", apart)
    return None


def _efforts_of(entry: Mapping[str, Any]) -> tuple[Any, str]:
    """Return what an entry has except its efforts' names (robot, format, columns, paths), and its
    efforts with their units in words.
    """
    paths, units = entry.get("channels", {}), entry.get("units", {})
    names = [re.sub(r"_\d$", "", str(column)) for column in entry.get("columns", paths)]
    columns = ["effort" if name in EFFORT_MEANINGS else name for name in names]
    told = [f"{n} [{units.get(n, 'SI')}]" for n in dict.fromkeys(names) if n in EFFORT_MEANINGS]
    form = entry.get("robot"), entry.get("format"), columns, [*paths.values()]
    return form, " and ".join(told) or "no efforts"
