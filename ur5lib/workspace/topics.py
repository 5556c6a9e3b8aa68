"""The topics' modules, found by a loop over their folders: no list names them."""

from importlib import import_module
from types import ModuleType

from ur5lib.workspace.places import PACKAGE


def modules_of_topics(name: str) -> dict[str, ModuleType]:
    """Return by topic its module with a name, for the topics that have such a module."""
    topics = sorted(path.parent.name for path in PACKAGE.glob(f"topics/*/{name}.py"))
    return {topic: import_module(f"ur5lib.topics.{topic}.{name}") for topic in topics}
