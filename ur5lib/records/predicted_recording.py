"""A recording with the currents that its motion needs without contact."""

from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.prediction import Prediction


class PredictedRecording(AlignedRecording):
    """What is known of a recording before its forces are estimated."""

    currents: Currents
    prediction: Prediction
