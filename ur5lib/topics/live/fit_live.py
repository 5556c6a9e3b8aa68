"""What the live estimator learns of an arm from recordings without contact."""

from collections.abc import Mapping

from ur5lib.errors import InputError, RefusalError, Remark
from ur5lib.force.residual_model import Residuals
from ur5lib.records.codes import CauseCode
from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.topics.live.live_file import LiveFit, learned, numbers


@step("arm", "live.json", recordings="fit")
def fit_live(
    signals: Mapping[str, Signals],
    premises: Mapping[str, Premises],
    friction: Friction,
    residuals: Residuals,
    arm: Robot,
    gravities: dict[str, list[float] | None],
    false_alarms_per_min: float,
    contact_force_n: float | None,
) -> LiveFit:
    """Return the noise and the threshold of an arm; each recording uses the fit without its path.

    Empty without a fit; `refused` gives the reason if no force may be stated. signals, premises,
    gravities: of the arm's `fit` recordings; contact_force_n: of a typical contact [N], None: from
    the arm's payload.
    """
    for refused in (friction.stopped, friction.refused, residuals.refused):
        if refused is not None:
            return LiveFit(refused=refused)
    if not friction.from_:
        return LiveFit()
    under = {name: arm.mounted(gravity) for name, gravity in gravities.items()}
    try:
        for own in premises.values():  # the exported fit to all recordings may be refused, too
            numbers(arm, friction, "", own.load.payload, own.place, contact_force_n)
        runs = [
            (
                numbers(under[name], friction, name, own.load.payload, own.place, contact_force_n),
                run,
            )
            for name, own in premises.items()
            if name in friction.from_ and (run := Measured.of(signals[name])) is not None
        ]
        return LiveFit(learned(runs, friction.paths, false_alarms_per_min))
    except RefusalError as refusal:
        return LiveFit(refused=refusal.remark)
    except InputError as error:  # friction that couples joints
        return LiveFit(refused=Remark(CauseCode.OTHER_REASON, str(error)))
