"""Limits of verdicts; docs/report.md explains the states that follow from them."""

from ur5lib.records.quality import MAX_SHARE_UNMODELLED

MIN_DIFFERENCE = 5e-5  # two errors count as equal if they differ by less
MIN_GOOD_SKILL = 0.5  # smallest skill of a good estimate: less than half the error of zero
MIN_LINK_SKILL = 1 - MAX_SHARE_UNMODELLED  # smallest skill of a good link model
BETTER_RIVAL_RATIO = 0.95  # a rival's error below this share of an error is clearly less
# A good estimate's error is at most this many times the difference between repeated motions.
MAX_GOOD_FLOORS = 3.0
MIN_GOOD_COVERAGE = 0.9  # smallest share of readings in a good 95 % band
MIN_USABLE_COVERAGE = 0.5  # smallest share of readings in a usable 95 % band
MIN_GOOD_BAND_FACTOR = 0.5  # a 95 % band is too wide if this share of its width contains 95 %
MIN_LINK_TORQUE = 0.1  # Nm; link models are judged at joints with a larger mean torque
MIN_PUSH = 1.0  # N; an axis counts as pushed above this mean force
MAX_BLIND_SHARE = 0.5  # a useful band contains zero for at most this share of the time in contact
MAX_HALF_INTERVAL = 0.5  # a number known within this share of it or worse is doubtful
MAX_CHANCE_OF_ALARMS = 0.05  # a recording with a less probable number of alarms was touched
USUAL_ALARMS, USUAL_SECONDS = 0.02, 60.0  # prior: false alarms in this time
MAX_GOOD_PEAK_ERROR = 0.25  # share of a contact's peak by which its estimate may be too small
# Log-odds: fits of a UR5, a UR10e and the default study have 0, with hidden contacts 15.
MAX_USUAL_THRESHOLD = 5.0
UPPER_LIMIT = 0.95  # probability of a rate's upper limit
BELIEVED = 0.95  # share of 95 % intervals that hold the truth
MAX_LOAD_ERROR = 0.25  # of a load that the arm carries well, a tenth of the rated one
GOOD_ALARM_RATE = 1.0  # 1/min; if the upper limit without any alarm exceeds it, time is too short
MAX_DRIFT_ERROR = 1.0  # N/min; largest half-width of a determined drift's 95 % interval
HIGH_LOST_SHARE = 0.1  # a recording with this share of lost frames should be repeated
