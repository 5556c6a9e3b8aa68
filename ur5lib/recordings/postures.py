"""Postures at rest, of a recording without time: read, and rows of one posture joined."""

import numpy as np
import pandas as pd

from ur5lib.channels import EFFORT_CHANNELS, columns
from ur5lib.errors import InputError
from ur5lib.recordings.copies import fingerprint
from ur5lib.recordings.counting import counted_as
from ur5lib.recordings.entries import Files
from ur5lib.recordings.formats import read_recording
from ur5lib.recordings.intake import bounds_of, known_frames
from ur5lib.recordings.plausibility import drop_implausible
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Quality, add_finding
from ur5lib.robots.description import Robot
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels

# In rad. Consecutive rows that differ by less in each joint are one posture.
MAX_POSTURE_CHANGE = 0.005
CHANNELS_AT_REST = (  # channels that are used
    *("actual_q", "target_q", "target_moment", *EFFORT_CHANNELS),
    *("payload", "payload_cog", "payload_inertia", "tcp_offset"),
)


def read_postures(recording: Files, arm: Robot) -> tuple[pd.DataFrame, Quality]:
    """Return the means of a recording's channels over the rows of each posture at rest, and its
    quality.

    Raises InputError where it has no efforts, or cannot be used.
    """
    raw = read_recording(recording)
    frames, findings = known_frames(raw, counted_as(recording, arm))
    findings += raw.findings
    source = raw.robot.source
    whole = _complete(frames, source, arm, findings)
    rows = drop_implausible(
        whole, source, "robot", findings, bounds_of(arm, recording.unknown_unit())
    )
    usable = (name for one in CHANNELS_AT_REST for name in columns(one, len(arm.joints)))
    used = [name for name in usable if name in rows]
    postures = rows[used].groupby(_posture(channel(rows, "actual_q"))).mean()
    quality = Quality(
        rows=len(frames),
        frames=len(postures),
        duration_s=np.nan,
        jitter_s={"median": np.nan, "99 %": np.nan},
        devices=["robot"],
        findings=findings,
        fingerprint=fingerprint(frames),
        account=recording.account,
    )
    return postures, quality


def _complete(
    frames: pd.DataFrame, source: str, arm: Robot, findings: list[Finding]
) -> pd.DataFrame:
    """Return the rows with all positions and efforts. Raises InputError if there are fewer than
    two.
    """
    joints, effort = len(arm.joints), arm.measured
    needed = columns("actual_q", joints) + columns(effort.channel, joints)
    if not {*needed} <= {*frames}:
        raise InputError(
            f"{source}: has no {effort.channel}_0 to {effort.channel}_{joints - 1}, "
            "without which postures at rest tell nothing; name their columns in the study"
        )
    whole = np.isfinite(frames[needed].to_numpy(float)).all(axis=1)
    if whole.sum() < 2:
        raise InputError(
            f"{source}: contains only {whole.sum()} rows with positions and {effort.quantity}s; "
            "record more"
        )
    detail = "rows with empty cells; discarded"
    add_finding(findings, "robot", Found.MISSING_CELLS, "warning", (~whole).sum(), detail)
    return frames[whole].reset_index(drop=True)


def _posture(q: Array) -> Labels:
    """Return the number of the posture (N,) of each row; q: positions (N, n) [rad]."""
    first, label, labels = q[0], 0, []
    for row in q:
        if np.abs(row - first).max() > MAX_POSTURE_CHANGE:
            first, label = row, label + 1
        labels.append(label)
    return np.array(labels)
