"""A recording with the currents predicted for its motion without contact."""

from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.prediction import Prediction


class PredictedRecording(AlignedRecording):
    """A recording with its predicted currents, before its forces are estimated."""

    currents: Currents
    prediction: Prediction
