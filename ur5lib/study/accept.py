"""The reasons for which a study overrules stop signs, one for each kind."""

from typing import Annotated, Any

from pydantic import AfterValidator, Field, field_validator

from ur5lib.strict import Strict


def _stated(reason: str) -> str:
    if not reason.strip():
        raise ValueError("the reason, as text")
    return reason.strip()


Reason = Annotated[str, AfterValidator(_stated)]


def _kind(claim: str) -> str | None:
    default: None = Field(None, description=f"why {claim}")
    return default


class Accept(Strict):
    """The reasons for which the study overrules stop signs, by the kind of the sign.

    The report repeats them.
    """

    constants: Reason | None = _kind("torque constants may differ from those of the motors")
    delay: Reason | None = _kind("currents or torques may come before or after the motion")
    mounting: Reason | None = _kind("gravity has the declared direction")
    order: Reason | None = _kind("no joints are exchanged")
    payload: Reason | None = _kind("the arm carries no more than is declared")
    rectified: Reason | None = _kind("currents or torques have their signs")
    robot: Reason | None = _kind("it is this arm")
    sampling: Reason | None = _kind("the samples tell the motion between them")
    side: Reason | None = _kind("torques are on the side of the gears that the arm's `effort` says")
    sign: Reason | None = _kind("no current or torque has the opposite sign")
    targets: Reason | None = _kind("measurements may be as smooth as targets, or equal them")
    torques: Reason | None = _kind("torques may stay the same in motion")
    unit: Reason | None = _kind("currents and torques are in the declared unit")
    velocity: Reason | None = _kind("velocities may differ from the slopes of positions")

    @field_validator("*", mode="before")
    @classmethod
    def _is_stated(cls, reason: Any) -> Any:
        """Return the reason of a kind, None without one. Raises ValueError if it has no words."""
        return _stated("") if reason is None else reason


def joined(general: Accept | None, own: Accept | None) -> Accept | None:
    """Return the reasons of a study (general) together with those of one of its recordings (own),
    which take precedence.
    """
    if general is None or own is None:
        return general or own
    return general.model_copy(update=own.model_dump(exclude_none=True))
