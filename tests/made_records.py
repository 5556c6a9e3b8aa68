"""Records of the pipeline, made up of a few arrays, and whether two hold the same samples."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.records.table import Table
from ur5lib.timeseries.arrays import Array


def stretch(time: Array) -> dict[str, Any]:
    """The fields of an unbroken stretch."""
    return {"time": time, "segment": np.zeros(len(time), np.int64)}


def signals_of(time: Array, q: Array, **channels: Array | None) -> Signals:
    """Without a lost frame, but for `interpolated` among the channels."""
    flags = {"interpolated": np.zeros(len(time), bool)}
    return Signals(**stretch(time), actual_q=q, **flags | channels)


def motion_of(time: Array, q: Array, qd: Array, qdd: Array | None = None) -> Motion:
    """Of rigid links, known exactly; by default at a steady pace."""
    exact = {"q": q, "qd": qd, "qdd": 0 * q if qdd is None else qdd}
    std = {f"{name}_std": 0 * q for name in exact}
    return Motion(**stretch(time), **exact, **std, motor_qd=qd)


def torques_of(
    time: Array, target: Mapping[str, Array], measured: Mapping[str, Array] | None = None
) -> Torques:
    """By link model; with no payload beyond the one that the controller was given."""
    known = {"target": {**target}, "measured": {**(measured or {})}}
    nothing = 0 * next(iter((known["target"] | known["measured"]).values()))
    lost = np.zeros(len(time), bool)
    return Torques(**stretch(time), interpolated=lost, **known, payload_torque=nothing)


def same(own: Table, other: Table) -> None:
    assert type(own) is type(other)
    for field in fields(own):
        values = [getattr(record, field.name) for record in (own, other)]
        by_key = [dict(value) if isinstance(value, Mapping) else value for value in values]
        np.testing.assert_equal(*by_key)
