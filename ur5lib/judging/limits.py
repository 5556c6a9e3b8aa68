"""Limits of verdicts; docs/report.md explains the states that follow from them."""

from ur5lib.records.quality import MAX_SHARE_UNMODELLED

MIN_DIFFERENCE = 5e-5  # of two errors, that four decimals show; smaller ones are equal
MIN_GOOD_SKILL = 0.5  # smallest skill of a good estimate: less than half the error of zero
MIN_LINK_SKILL = 1 - MAX_SHARE_UNMODELLED  # of a good link model
BETTER_RIVAL_RATIO = 0.95  # share of an error, below which another is clearly less
MAX_GOOD_FLOORS = 3.0  # of a good estimate's error, in what repetition alone leaves
MIN_GOOD_COVERAGE = 0.9  # smallest share of readings in a good 95 % band
MIN_USABLE_COVERAGE = 0.5  # smallest share, below which a 95 % band fails
MIN_GOOD_BAND_FACTOR = 0.5  # at this share of its width, a good 95 % band would be too narrow
MIN_LINK_TORQUE = 0.1  # Nm of the mean torque at a joint by which a link model is judged
MIN_PUSH = 1.0  # mean force [N] along an axis that is pushed
MAX_BLIND_SHARE = 0.5  # of the time in contact in which a useful band may contain zero
MIN_USABLE_SHARE = 0.5  # of joints, above which constants are usable
MAX_CHANCE_OF_ALARMS = 0.05  # of as many in any recording, at the rate of the others
USUAL_ALARMS, USUAL_SECONDS = 0.02, 60.0  # false alarms where there are no others
UPPER_LIMIT = 0.95  # probability of a rate's upper limit
GOOD_ALARM_RATE = 1.0  # a minute, above which an upper limit says that recordings are short
MAX_DRIFT_ERROR = 1.0  # N/min, half of the 95 % interval of a drift that is determined
HIGH_LOST_SHARE = 0.1  # share of lost frames from which a recording is worth repeating
