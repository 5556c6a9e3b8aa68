"""Estimators of the contact force, one file each; a file's ESTIMATORS are rows of the table."""

import importlib
import pkgutil

from ur5lib.leaderboard.estimator import Estimator


def all_estimators() -> list[Estimator]:
    """Return the estimators of all files of this folder, in the order of the files' names."""
    names = [f"{__name__}.{own.name}" for own in pkgutil.iter_modules(__path__)]
    return [own for name in names for own in importlib.import_module(name).ESTIMATORS]
