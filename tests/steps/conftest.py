"""Scripts as modules, run without Snakemake."""

import importlib.util
from types import ModuleType

from tests.conftest import PROJECT


def script(name: str) -> ModuleType:
    """A workflow script, imported."""
    path = PROJECT / "workflow" / "scripts" / f"{name}.py"
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
