"""What the steps know of a made-up recording: records that say nothing but what a test gives."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from tests.made_records import stretch, torques_of
from tests.made_tables import record
from ur5lib.force.residual_model import Residuals
from ur5lib.jobs.files import assembled
from ur5lib.records.carried import Carried
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Contradictions, Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.steps.read_recording import NO_SAMPLES
from ur5lib.timeseries.lowpass import Butterworth

NO_LOAD = Carried(None, "none", None)
CURRENTS_LOWPASS, CONTACT_FORCE = Butterworth(4, 2.0), 15.0  # N


def premises(*signs: Any, load: Carried = NO_LOAD) -> Premises:
    """Premises with some stop signs."""
    return Premises(load, Contradictions([*signs]))


def aligned(clocks: dict[str, Any] | None = None) -> Alignment:
    return Alignment(clocks or {}, record(Alignment, {"clocks": {}}).encoders)


class Known(SimpleNamespace):
    """Records and settings by the names that steps ask for them."""

    def but(self, **others: Any) -> "Known":
        return Known(**vars(self) | others)

    def run(self, step: Callable[..., Any]) -> Any:
        return step(**assembled(step, {}, vars(self)))


def known_of(
    arm: Robot, signals: Signals, motion: Motion, kinematics: Kinematics, **known: Any
) -> Known:
    """Nothing is known besides: no currents, no forces, no sensor."""
    grid = stretch(signals.time)
    usual: dict[str, Any] = {
        "name": "made",
        "role": "contact",
        "date": "",
        "gravity": None,
        "untouched": None,
        "chain": (),
        "before": {},
        "quality": Quality(),
        "force": NO_SAMPLES,
        "alignment": aligned(),
        "torques": torques_of(signals.time, {"C": 0 * motion.q}, {"C": 0 * motion.q}),
        "premises": premises(),
        "currents": Currents(**grid),
        "prediction": Prediction(False),
        "forces": Forces(**grid),
        "further": None,
        "sensor": SensorWrenches(**grid),
        "compared": Compared(),
        "friction": Friction(),
        "residuals": Residuals(),
        "threshold": {},
        "cutoff_hz": CURRENTS_LOWPASS.cutoff,
        "lowpass": CURRENTS_LOWPASS,
        "contact_force_n": CONTACT_FORCE,
        "bias_window_s": 1.0,
        "min_singular_value": 0.01,
    }
    own = {"arm": arm, "signals": signals, "motion": motion, "kinematics": kinematics}
    return Known(**usual | own | known)
