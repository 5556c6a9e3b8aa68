"""The Slurm jobs in which the steps of topics run; `profiles/slurm` names those of the others."""

import re

from ur5lib.jobs.code import module_of
from ur5lib.jobs.declared import Declared, every
from ur5lib.workspace.places import PACKAGE


def groups_of_topics() -> dict[str, str]:
    """Return the group of each step of a topic; of one with a rule of its own, "document"."""
    rules = (path.read_text(encoding="utf-8") for path in PACKAGE.glob("topics/*/rules.smk"))
    own = [name for text in rules for name in re.findall(r"^ *rule (\w+):", text, re.MULTILINE)]
    steps = [step for step in every() if "topics" in module_of(step.name).parts]
    awaited = {
        name
        for step in steps
        if step.of == "recording"
        for name in {*step.reads.values()} - {step.reads[several] for several in step.several}
    }
    return dict.fromkeys(own, "document") | {step.name: _group(step, awaited) for step in steps}


def _group(step: Declared, awaited: set[str]) -> str:
    """Return the group of a step; awaited: the outputs that steps of recordings read."""
    if step.of == "recording":
        return "forces" if "further" in step.writes else "judgement"
    return "fits" if awaited & step.writes.keys() else "document"
