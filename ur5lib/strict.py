"""Data that people write by hand."""

from pydantic import BaseModel, ConfigDict


class Strict(BaseModel):
    """A part of a hand-written file: unknown keys are errors, values stay as read."""

    model_config = ConfigDict(extra="forbid", frozen=True)
