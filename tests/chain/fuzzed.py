"""Damaged models, as `Model.save` writes them."""

import json
import random
from pathlib import Path

import pandas as pd

import ur5lib
from tests.damage import damaged_file
from tests.damaged_values import other_value
from tests.fuzz import Attempt
from tests.in_memory import FREE, put_recordings
from ur5lib.chain.model import TABLES


def models(folder: Path) -> Attempt:
    """Return what loads a damaged model, shows it, and estimates a force with one that it takes."""
    put_recordings(folder)
    fitted = ur5lib.fit(ur5lib.read([folder / name for name in FREE], "ur5e"))
    pd.read_csv(folder / "pushed.csv")[:700].to_csv(folder / "short.csv", index=False)
    pushed = ur5lib.read(folder / "short.csv", "ur5e", role="contact")
    fitted.save(folder / "model.json")
    text = (folder / "model.json").read_text()

    def attempt(draw: random.Random, place: Path) -> None:
        file = place / "model.json"
        if draw.random() < 0.3:
            file.write_bytes(damaged_file(text.encode(), draw).data)
        else:
            file.write_text(json.dumps(other_value(json.loads(text), draw)))
        model = ur5lib.load_model(file)
        repr(model)
        model.table(draw.choice(TABLES))
        model.estimate(pushed)

    return attempt


TARGETS = {"models": models}
