"""The Slurm jobs in which the steps of topics run; `profiles/slurm` names those of the others."""

import re
from collections.abc import Iterator
from pathlib import Path

from ur5lib.workspace.places import PACKAGE

RULE = re.compile(r"^ *rule (\w+):\n(.*?)(?=^ *rule |\Z)", re.MULTILINE | re.DOTALL)


def groups_of_topics() -> dict[str, str]:
    """Return the group of each step of a topic."""
    files = sorted(PACKAGE.glob("topics/*/rules.smk"))
    return dict(pair for file in files for pair in _groups(file))


def _groups(rules: Path) -> Iterator[tuple[str, str]]:
    """Yield each step of a file of rules with its group.

    A recording's step is in the group "judgement", or in "forces" if it estimates forces, which
    thresholds need. An arm's step is in the group "document", or in "fits" if recordings need it.
    """
    text = rules.read_text(encoding="utf-8")
    for step, body in RULE.findall(text):
        made = re.findall(r'parameter\("([^"]+)"\)', body.partition("output:")[2])
        if '"{recording}")' in body:
            further = re.findall(r'FURTHER_FORCES\.append\("([^"]+)"\)', text)
            stated = any(f'result("{file}")' in body.partition("output:")[2] for file in further)
            yield step, "forces" if stated else "judgement"
        else:
            awaited = any(f'parameter_of("{file}")' in text for file in made)
            yield step, "fits" if awaited else "document"
