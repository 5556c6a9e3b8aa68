"""A recording with its forces, and what they are compared with."""

from ur5lib.records.accelerations import Accelerations, ImuComparison
from ur5lib.records.contacts import Contacts
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.motion import FusedMotion
from ur5lib.records.predicted_recording import PredictedRecording


class EstimatedRecording(PredictedRecording):
    """All that is known of a recording.

    further: a topic's estimates of its force, None without.
    """

    forces: Forces
    further: FurtherForces | None
    fused: FusedMotion
    accelerations: Accelerations
    comparison: ImuComparison
    sensor: SensorWrenches
    compared: Compared
    contacts: Contacts
