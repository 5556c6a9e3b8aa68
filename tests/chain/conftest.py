"""Recordings of a simulated arm, and the model that is fitted to them."""

from pathlib import Path

import pytest

import ur5lib
from tests.in_memory import FREE, put_recordings


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    put_recordings(folder)
    return folder


@pytest.fixture(scope="session")
def free(folder: Path) -> ur5lib.Recordings:
    return ur5lib.read([folder / name for name in FREE], "ur5e")


@pytest.fixture(scope="session")
def model(free: ur5lib.Recordings) -> ur5lib.Model:
    return ur5lib.fit(free)


@pytest.fixture(scope="session")
def pushed(folder: Path) -> ur5lib.Recordings:
    return ur5lib.read(folder / "pushed.csv", ur5lib.read_arm("ur5e"), role="contact")
