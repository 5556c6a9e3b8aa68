"""Codes of findings, and of causes of stop signs and remarks: closed lists, stable over versions.

Whoever looks one up does so by its code: `git grep -w LOST_FRAMES` shows who finds lost frames, and
who asks for the finding; what computes sees filled frames by their flag, `interpolated`.
Reasons and advice have theirs in `ur5lib/records/verdicts.py`.
"""

import re
from enum import StrEnum
from typing import Self


class Found(StrEnum):
    """What is found in a recording's files: its code, as in the column `code` of quality.csv.

    words: its name in English, for pages and the column `finding`, which nothing looks up.
    """

    words: str

    def __new__(cls, code: str, words: str = "") -> Self:
        """Return a member with its name in English."""
        member = str.__new__(cls, code)
        member._value_, member.words = code, words
        return member

    @classmethod
    def _missing_(cls, value: object) -> Self:
        """Return the code of a finding's name in version 1.0, which wrote no codes."""
        code = re.sub(r"\W+", "_", str(value))
        return next((one for one in cls if one == code), cls.OTHER)

    ACCEPTED_STOP_SIGN = "accepted_stop_sign", "accepted stop sign"
    ARM_NOT_CHECKED = "arm_not_checked", "arm not checked"
    ASSUMED_FRAME = "assumed_frame", "assumed frame"
    BUNCHED_STAMPS = "bunched_stamps", "bunched stamps"
    BYTES_SKIPPED = "bytes_skipped", "bytes skipped"
    BYTE_ORDER_MARK = "byte_order_mark", "byte-order mark"
    CHANGING_PAYLOAD = "changing_payload", "changing payload"
    CHANNELS_OF_UNEQUAL_LENGTH = "channels_of_unequal_length", "channels of unequal length"
    CLOCK_BY_STAMPS_ALONE = "clock_by_stamps_alone", "clock by stamps alone"
    CLOCK_NOT_CHECKED = "clock_not_checked", "clock not checked"
    CLOCK_RESET = "clock_reset", "clock reset"
    COLUMNS_NOT_CHECKED = "columns_not_checked", "columns not checked"
    COLUMNS_NOT_USED = "columns_not_used", "columns not used"  # left out by import
    COMPRESSED_FILE = "compressed_file", "compressed file"
    CONTACT = "contact", "contact"  # that the role of the recording rules out
    CONTACT_NOT_CHECKED = "contact_not_checked", "contact not checked"
    CONTRACT = "contract", "contract"  # a lab's contract is violated
    CONTRADICTION = "contradiction", "contradiction"
    CROWDED_FRAMES = "crowded_frames", "crowded frames"
    CURRENTS_FROM_TORQUES = "currents_from_torques", "currents from torques"
    CURRENTS_NOT_CHECKED = "currents_not_checked", "currents not checked"
    DAMAGED_LINES = "damaged_lines", "damaged lines"
    DAMAGED_MESSAGES = "damaged_messages", "damaged messages"
    DECIMAL_COMMAS = "decimal_commas", "decimal commas"
    ENDS = "ends", "ends"  # first and last row, of each recording
    FAST_BETWEEN_SAMPLES = "fast_between_samples", "fast between samples"
    FRAMES_OUT_OF_ORDER = "frames_out_of_order", "frames out of order"
    FROZEN_CHANNEL = "frozen_channel", "frozen channel"
    GIVEN_LOAD = "given_load", "given load"  # to the controller, unknown to the study
    GRAVITY_ADDED = "gravity_added", "gravity added"
    HELD_SAMPLES = "held_samples", "held samples"
    IMPOSSIBLE_FRAMES = "impossible_frames", "impossible frames"
    IMPOSSIBLE_SAMPLES = "impossible_samples", "impossible samples"
    IMPOSSIBLE_TIMES = "impossible_times", "impossible times"
    INCOMPLETE_CHANNELS = "incomplete_channels", "incomplete channels"
    INCOMPLETE_FRAMES = "incomplete_frames", "incomplete frames"
    INCOMPLETE_MESSAGE = "incomplete_message", "incomplete message"
    INCONSISTENT_CHANNELS = "inconsistent_channels", "inconsistent channels"
    IRREGULAR_STEPS = "irregular_steps", "irregular steps"
    JITTER = "jitter", "jitter"
    JOINTS_BEYOND_THEIR_RANGE = "joints_beyond_their_range", "joints beyond their range"
    JOINT_LIMITS = "joint_limits", "joint limits"
    LATE_DATA = "late_data", "late data"
    LESS_GRAVITY = "less_gravity", "less gravity"
    LINKS_IN_DOUBT = "links_in_doubt", "links in doubt"
    LOAD_CHANGES = "load_changes", "load changes"
    LOST_FRAMES = "lost_frames", "lost frames"
    LOST_SAMPLES = "lost_samples", "lost samples"
    MISSING_CELLS = "missing_cells", "missing cells"
    MISSING_LAST_ROW = "missing_last_row", "missing last row"  # one row less than other files
    MISSING_TIMES = "missing_times", "missing times"
    MISSPELT_CHANNELS = "misspelt_channels", "misspelt channels"
    MOUNTING = "mounting", "mounting"
    MOVED_IN_BETWEEN = "moved_in_between", "moved in between"
    NAMELESS_JOINTS = "nameless_joints", "nameless joints"  # of messages without names
    NEEDLESS_REASON = "needless_reason", "needless reason"
    NOTHING_CHECKED = "nothing_checked", "nothing checked"
    NO_CURRENTS = "no_currents", "no currents"
    NO_GRAVITY = "no_gravity", "no gravity"
    NO_MOMENTS = "no_moments", "no moments"
    NO_MOTION = "no_motion", "no motion"
    NO_SENSOR = "no_sensor", "no sensor"
    NO_START_STAMP = "no_start_stamp", "no start stamp"
    NO_VELOCITIES = "no_velocities", "no velocities"
    ODD_TARGET = "odd_target", "odd target"  # of a current
    OFFSET = "offset", "offset"
    ORDER_NOT_CHECKED = "order_not_checked", "order not checked"
    OTHER_CONTACT_PLACE = "other_contact_place", "other contact place"
    OTHER_LAYOUTS = "other_layouts", "other layouts"
    OTHER_MESSAGES = "other_messages", "other messages"
    OTHER_RATE_THAN_NAMED = "other_rate_than_named", "other rate than named"
    PARTS_OF_ONE_RUN = "parts_of_one_run", "parts of one run"
    PART_MISSING = "part_missing", "part missing"
    PAYLOAD = "payload", "payload"
    POSSIBLE_DELAY = "possible_delay", "possible delay"
    POSTURES = "postures", "postures"
    REPEATED_COMMAND = "repeated_command", "repeated command"  # efforts as of another recording
    REPEATED_FRAMES = "repeated_frames", "repeated frames"
    REPEATED_STAMPS = "repeated_stamps", "repeated stamps"
    SAME_FILE = "same_file", "same file"  # a device's file is a copy of another recording's
    SAME_RUN = "same_run", "same run"  # as another recording
    SAMPLES_OUT_OF_ORDER = "samples_out_of_order", "samples out of order"
    SATURATION = "saturation", "saturation"
    SCALED_CURRENT = "scaled_current", "scaled current"
    SIGN_NOT_CHECKED = "sign_not_checked", "sign not checked"
    SILENT_CHANNEL = "silent_channel", "silent channel"
    SIZE_NOT_CHECKED = "size_not_checked", "size not checked"
    SIZE_OF_GRAVITY = "size_of_gravity", "size of gravity"
    SLOWER_THAN_FIT = "slower_than_fit", "slower than fit"
    SLOW_CHANNELS = "slow_channels", "slow channels"
    SLOW_SAMPLES = "slow_samples", "slow samples"
    SPLIT = "split", "split"
    STALE_COPY = "stale_copy", "stale copy"
    STALE_DATA = "stale_data", "stale data"
    STALE_STAMPS = "stale_stamps", "stale stamps"
    TOOL_CENTRE_POINT = "tool_centre_point", "tool centre point"
    TOO_SHORT = "too_short", "too short"
    TORN_LAST_LINE = "torn_last_line", "torn last line"
    TORQUES_BY_ANOTHER_NAME = "torques_by_another_name", "torques by another name"
    TORQUES_NOT_CHECKED = "torques_not_checked", "torques not checked"
    TORQUE_CONSTANTS = "torque_constants", "torque constants"
    TOUCHED = "touched", "touched"  # a sensor reads contacts that the role rules out
    TOUCHED_TARE = "touched_tare", "touched tare"
    TURNED_TABLE = "turned_table", "turned table"  # a row a joint
    UNDECLARED_LOAD = "undeclared_load", "undeclared load"
    UNFILTERED = "unfiltered", "unfiltered"
    UNIT_NOT_CHECKED = "unit_not_checked", "unit not checked"
    UNKNOWN_CHANNELS = "unknown_channels", "unknown channels"
    UNKNOWN_DRIFT = "unknown_drift", "unknown drift"
    UNMOVED = "unmoved", "unmoved"
    UNNAMED_JOINTS = "unnamed_joints", "unnamed joints"  # of messages
    UNREAD = "unread", "unread"  # what of a file has no rows of numbers
    UNREADABLE = "unreadable", "unreadable"
    UNUSABLE = "unusable", "unusable"
    UNUSABLE_SENSOR = "unusable_sensor", "unusable sensor"
    UNUSABLE_TARE = "unusable_tare", "unusable tare"
    UNUSED_CHANNELS = "unused_channels", "unused channels"
    UNUSED_WRENCH = "unused_wrench", "unused wrench"
    UNUSUAL_FRICTION = "unusual_friction", "unusual friction"  # hides a contact's force
    UNWRITTEN_CHANNELS = "unwritten_channels", "unwritten channels"
    WRAPPED_ANGLES = "wrapped_angles", "wrapped angles"
    WRIST_SENSOR = "wrist_sensor", "wrist sensor"
    ZEROED = "zeroed", "zeroed"
    ZEROED_CELLS = "zeroed_cells", "zeroed cells"
    OTHER = "other", "of another version"


class CauseCode(StrEnum):
    """The cause of a stop sign, a doubt or a remark; the column `code` of remarks.csv."""

    @classmethod
    def _missing_(cls, _: object) -> Self:
        """Return the code for a cause that only another version knows."""
        return cls.OTHER_REASON

    ACCEPTED_STOP_SIGN = "accepted stop sign"
    CONSTANT_TORQUES = "constant torques"
    CONTRADICTING_CONSTANTS = "contradicting constants"
    CONTRADICTING_GAINS = "contradicting gains"
    CONTRADICTING_RECORDINGS = "contradicting recordings"
    COPIED_RECORDINGS = "copied recordings"
    CURRENT_AGAINST_CONSTANT = "current against constant"
    CURRENT_IN_MA = "current in mA"
    CURRENT_NOT_IN_MA = "current not in mA"
    DISPUTED_BIAS = "disputed bias"
    DOUBTFUL_LINKS = "doubtful links"
    EARLY_CURRENT = "early current"
    EARLY_JOINT = "early joint"
    EXCHANGED_CHANNELS = "exchanged channels"
    EXCHANGED_CURRENTS = "exchanged currents"
    EXCHANGED_JOINTS = "exchanged joints"
    EXCHANGED_JOINTS_AT_REST = "exchanged joints at rest"
    EXPLAINED_CONTRADICTION = "explained contradiction"
    FAR_FRICTION = "far friction"
    FAST_CLOCK = "fast clock"
    FEW_FREE_SAMPLES = "few free samples"
    FEW_PATHS = "few paths"
    FOREIGN_BODIES = "foreign bodies"
    FOREIGN_CONSTANT = "foreign constant"
    FOREIGN_CONSTANT_OF_KNOWN_CAUSE = "foreign constant of known cause"
    FOREIGN_SIZE = "foreign size"
    FOREIGN_SIZE_OF_LINKS = "foreign size of links"
    GRAVITY_UNEXPLAINED = "gravity unexplained"
    HIDDEN_CONTACT = "hidden contact"
    IMPLAUSIBLE_CLOCK = "implausible clock"
    IN_DEGREES = "in degrees"
    LATE_CURRENT = "late current"
    LATE_JOINT = "late joint"
    LITTLE_OVERLAP = "little overlap"
    LITTLE_REST = "little rest"
    LOAD_CHANGES = "load changes"
    MISSING_LOAD = "missing load"
    MISSING_ROTORS = "missing rotors"
    MISSING_SPRING = "missing spring"
    MOTION_DETERMINES = "motion determines"
    NO_BODIES = "no bodies"
    NO_CURRENT = "no current"
    NO_FIT_IN_MOTION = "no fit in motion"
    NO_FIT_RECORDING = "no fit recording"
    NO_FIT_TORQUES = "no fit torques"
    NO_KNOWN_TORQUE = "no known torque"
    NO_MOTION = "no motion"
    NO_MOTION_DETERMINES = "no motion determines"
    NO_TORQUE_OF_JOINTS = "no torque of joints"
    NO_VELOCITY = "no velocity"
    ONE_BLOCK = "one block"
    ONE_PATH = "one path"
    ONE_PATH_OF_ALL = "one path of all"
    OPPOSITE_CURRENT = "opposite current"
    OTHER_ARMS_CURRENTS = "other arm's currents"
    OTHER_ARMS_CURRENTS_AT_REST = "other arm's currents at rest"
    OTHER_MOUNTING = "other mounting"
    OTHER_MOUNTING_OR_SIGN = "other mounting or sign"
    OTHER_REASON = "other reason"
    OTHER_TORQUE = "other torque"
    OTHER_TORQUE_OF_KNOWN_CAUSE = "other torque of known cause"
    RARE_SAMPLES_LIVE = "rare samples live"
    RECTIFIED_EFFORTS = "rectified efforts"
    SCALED_CURRENT = "scaled current"
    SHORT_RECORD = "short record"
    SHORT_RECORDINGS = "short recordings"
    SIMULATED = "simulated"
    SLOW_CLOCK = "slow clock"
    SLOW_RECORD = "slow record"
    SPRING_ON_TOOL = "spring on the tool"
    STILL_JOINTS = "still joints"
    SURPLUS_ROTORS = "surplus rotors"
    TOOL_OFF_FLANGE = "tool off flange"
    TORQUE_AGAINST_GAIN = "torque against gain"
    TORQUE_AS_CURRENT = "torque as current"
    TURNED_CURRENT = "turned current"
    TURNED_CURRENT_AT_REST = "turned current at rest"
    TURNED_SENSOR = "turned sensor"
    TURNED_TORQUES = "turned torques"
    TWO_BIASES = "two biases"
    UNCERTAIN_CLOCK = "uncertain clock"
    UNDECLARED_LOAD = "undeclared load"
    UNEXPLAINED_ROTATION = "unexplained rotation"
    UNKNOWN_CONSTANT = "unknown constant"
    UNKNOWN_LINKS = "unknown links"
    UNKNOWN_SIDE = "unknown side"
    UNKNOWN_TORQUES = "unknown torques"
    UNKNOWN_UNIT = "unknown unit"
    UNLIKELY_CONSTANT = "unlikely constant"
    UNPROVEN_FIT = "unproven fit"
    UNTOLD_MOTION = "untold motion"
