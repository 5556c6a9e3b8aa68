"""The topics' modules, found by a loop over their folders: no list names them."""

from importlib import import_module
from types import ModuleType

from ur5lib.workspace.places import PACKAGE


def modules_of_topics(name: str) -> dict[str, ModuleType]:
    """Return the modules of topics that are called `name`, by topic; topics without such a module
    are left out.
    """
    topics = sorted(path.parent.name for path in PACKAGE.glob(f"topics/*/{name}.py"))
    return {topic: import_module(f"ur5lib.topics.{topic}.{name}") for topic in topics}
