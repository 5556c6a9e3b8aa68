"""Estimators of the contact force, one file each; a file's ESTIMATORS are rows of the table."""

import importlib
import pkgutil

from ur5rivals.estimator import Contender


def all_estimators() -> list[Contender]:
    """Return the estimators of all files of this folder, in the order of the files' names."""
    names = [f"{__name__}.{module.name}" for module in pkgutil.iter_modules(__path__)]
    return [module for name in names for module in importlib.import_module(name).ESTIMATORS]
