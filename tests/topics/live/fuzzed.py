"""Damaged files of live arms, and hostile streams."""

import json
import random
from pathlib import Path

import numpy as np

from tests.fuzz import Attempt
from tests.topics.live.made_arm import arm_file, hostile, push, samples
from tests.topics.live.test_arm_file import DAMAGES, right_file, verdict
from ur5lib.errors import InputError
from ur5lib.topics.live.live import Live


def arm_files(folder: Path) -> Attempt:
    """Return what loads a damaged file of an arm, and follows some samples with one it takes."""
    text = json.dumps(right_file(), ensure_ascii=False)

    def attempt(draw: random.Random, place: Path) -> None:
        file, dice = place / "arm.json", np.random.default_rng(draw.randrange(1 << 32))
        file.write_bytes(draw.choice(DAMAGES)(text, dice).encode("utf-8", "surrogateescape"))
        if verdict(file) == "refused":
            raise InputError("refused")

    return attempt


def streams(folder: Path) -> Attempt:
    """Return what follows a hostile stream of 2 s, with velocities or without."""
    run, arm = samples(2.0, True, push(1.0, 1.5, 0.0, 30.0, 0.0)), arm_file()

    def attempt(draw: random.Random, place: Path) -> None:
        estimator, known = Live(arm), draw.random() < 0.5
        for time, q, qd, current in hostile(run, draw.randrange(1 << 32)):
            answer = estimator.step(time, q, qd if known else None, current)
            assert np.isfinite([*answer.wrench, *answer.std]).all()

    return attempt


TARGETS = {"arm.json": arm_files, "streams": streams}
