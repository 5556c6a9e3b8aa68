"""A recording with its forces, and the sensor's wrenches that they are compared with."""

from ur5lib.records.accelerations import Accelerations, ImuComparison
from ur5lib.records.contacts import Contacts
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.motion import FusedMotion
from ur5lib.records.predicted_recording import PredictedRecording


class EstimatedRecording(PredictedRecording):
    """A recording with its estimated forces.

    further: force estimates of a topic, None without any.
    """

    forces: Forces
    further: FurtherForces | None
    fused: FusedMotion
    accelerations: Accelerations
    comparison: ImuComparison
    sensor: SensorWrenches
    compared: Compared
    contacts: Contacts
