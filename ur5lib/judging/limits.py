"""Limits of verdicts; docs/report.md explains the states that follow from them."""

from ur5lib.records.quality import MAX_SHARE_UNMODELLED

MIN_DIFFERENCE = 5e-5  # four decimals show such a difference of two errors; smaller ones are equal
MIN_GOOD_SKILL = 0.5  # smallest skill of a good estimate: less than half the error of zero
MIN_LINK_SKILL = 1 - MAX_SHARE_UNMODELLED  # a good link model has this skill
BETTER_RIVAL_RATIO = 0.95  # below this share of an error, another is clearly less
# A good estimate's error is at most this many times what repetition alone leaves.
MAX_GOOD_FLOORS = 3.0
MIN_GOOD_COVERAGE = 0.9  # smallest share of readings in a good 95 % band
MIN_USABLE_COVERAGE = 0.5  # smallest share, below which a 95 % band fails
MIN_GOOD_BAND_FACTOR = 0.5  # at this share of its width, a good 95 % band would be too narrow
MIN_LINK_TORQUE = 0.1  # Nm; at a joint with this mean torque, a link model is judged
MIN_PUSH = 1.0  # N; along an axis that is pushed, the force has this mean
MAX_BLIND_SHARE = 0.5  # a useful band may contain zero for this share of the time in contact
MIN_USABLE_SHARE = 0.5  # above this share of joints, constants are usable
MAX_CHANCE_OF_ALARMS = 0.05  # chance of as many in any recording, at the rate of the others
USUAL_ALARMS, USUAL_SECONDS = 0.02, 60.0  # false alarms where there are no others
UPPER_LIMIT = 0.95  # probability of a rate's upper limit
GOOD_ALARM_RATE = 1.0  # a minute; an upper limit above it says that recordings are short
MAX_DRIFT_ERROR = 1.0  # N/min; a determined drift has at most this half of a 95 % interval
HIGH_LOST_SHARE = 0.1  # from this share of lost frames on, a recording is worth repeating
