"""Base class of data that people write by hand."""

from pathlib import Path

from pydantic import BaseModel, ConfigDict


class Strict(BaseModel):
    """A part of a hand-written file: unknown keys are errors, values stay as read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def existing_file(path: str) -> str:
    """Return the path. Raises ValueError if there is no such file."""
    if not Path(path).is_file():
        raise ValueError("an existing file")
    return path
