"""Damaged studies."""

import random
import re
from pathlib import Path

import yaml

from tests.conftest import PROJECT
from tests.damage import damaged_file
from tests.damaged_values import other_value
from tests.fuzz import Attempt
from ur5lib.study.reading import read_study

OF_REAL_FILES = ("thesis", "kuka-kr300")  # which must be there


def studies(folder: Path) -> Attempt:
    """Return what reads a damaged study: one of the project's, in its bytes or in a value."""
    files = [PROJECT / "config.yaml", *sorted((PROJECT / "workflow" / "studies").glob("*.yaml"))]
    texts = [  # whose recordings are in a folder that exists
        re.sub(r"raw/[\w./-]+", str(folder), text)
        for file in files
        if "\nrecordings:" in (text := file.read_text()) and file.stem not in OF_REAL_FILES
    ]

    def attempt(draw: random.Random, place: Path) -> None:
        text, file = draw.choice(texts), place / "study.yaml"
        if draw.random() < 0.3:
            file.write_bytes(damaged_file(text.encode(), draw).data)
        else:
            plain = yaml.safe_load(text)
            for _ in range(draw.randint(1, 3)):
                plain = other_value(plain, draw) or plain
            file.write_text(yaml.safe_dump(plain))
        read_study(file)

    return attempt


TARGETS = {"studies": studies}
