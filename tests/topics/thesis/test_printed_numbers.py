"""Published numbers beside rebuilt ones: statuses, and numbers as errata say that they arose."""

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.real_arms import RealRecording, RealStudy
from tests.topics.pages import Shown, section
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.quality import Quality, StartOffset
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.report.results import Results
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries.metrics import mean_absolute_error
from ur5lib.topics.thesis.closed_loop import published_gains, simulated, tracking_of
from ur5lib.topics.thesis.explained_errors import explained_accelerations, loop_error
from ur5lib.topics.thesis.figure import euler_figure
from ur5lib.topics.thesis.printed_numbers import (
    PRINTED_COLUMNS,
    ExplainedRow,
    compared,
)
from ur5lib.topics.thesis.reference import (
    AccelerationError,
    Erratum,
    Lookup,
    LoopError,
    PrintedTable,
    PublishedValues,
    read_reference,
)

THESIS = PROJECT / "workflow" / "studies" / "thesis_reference.yaml"
RUN = "run"


def rebuilt(values: list[float], largest: float = 3.0) -> dict[str, pd.DataFrame]:
    """A table of one model's six numbers on two recordings, the other with wrong ones."""
    rows = [
        {"recording": name, "model": "A", "joint": joint, "mae": mae, "max": largest * mae}
        for name, known in ((RUN, values), ("other", [99.0] * 6))
        for joint, mae in enumerate(known, 1)
    ]
    return {"torque_mae": pd.DataFrame(rows)}


def reference(**more: object) -> PublishedValues:
    place = Lookup(table="torque_mae", value="mae", row="model")
    known = {
        "source": "Table 1",
        "recording": RUN,
        "rebuilt": place,
        "values": {"A": (2.0001, *(2.0,) * 5)},
    }
    table = PrintedTable.model_validate(known | more)
    erratum = Erratum(place="Table 1", error="2 % less", choice="none")
    return PublishedValues(printed={"torque_mae": table}, errata=(erratum,))


def statuses(own: list[float], said: list[float] | None = None, **more: object) -> list[str]:
    ways = [ExplainedRow(1, "torque_mae", "A", np.array(said))] if said else []
    rows = pd.DataFrame(compared(reference(**more), rebuilt(own), ways))
    return rows["status"].tolist()


def test_a_number_is_equal_explained_or_unexplained() -> None:
    found = statuses([2.0, 2.09, 2.11, 1.91, 1.89, np.nan], [2.0, 3.0, 2.09, 2.0, 3.0, 2.0])
    assert found == ["equal", "equal", "erratum 1", "equal", "unexplained", "erratum 1"]


def test_half_of_the_last_digit_counts_as_equal() -> None:
    """That of the most precise number, as trailing zeros are lost."""
    coarse = {"values": {"A": (0.2, 0.1, 0.1, 0.1, 0.1, 0.1)}}
    values = [0.249, 0.149, 0.151, 0.051, 0.049, 0.1]
    expected = ["equal", "equal", "unexplained", "equal", "unexplained", "equal"]
    assert statuses(values, **coarse) == expected
    fine = {"values": {"A": (0.2, 0.1, 0.1, 0.1, 0.1, 0.10003)}}
    assert statuses(values, **fine) == ["unexplained"] * 5 + ["equal"]


def test_tolerances_are_the_tables_own() -> None:
    assert statuses([2.19] * 6, relative=0.1) == ["equal"] * 6
    small = {"values": {"A": (0.9999, 1.0001, 0.5, 0.5, 0.5, 0.5)}, "below_one": 0.1}
    assert statuses([1.09, 1.09, 0.59, 0.61, 0.41, 0.39], **small) == [
        *("equal", "unexplained", "equal", "unexplained", "equal", "unexplained")
    ]


def test_one_number_is_the_largest_of_six() -> None:
    place = {"table": "torque_mae", "value": "max", "row": "model"}
    right = place | {"value": "mae"}
    rows = compared(
        reference(values={"A": (7.5,)}, rebuilt=place, right=right),
        rebuilt([1.0, 2.5, 0.5, 0.1, 0.2, 0.3]),
        [ExplainedRow(1, "torque_mae", "A", np.array([7.0, 6.0, 1, 1, 1, 1]))],
    )
    (row,) = rows
    assert (row["number"], row["right"]) == ("largest", 2.5)
    assert (row["rebuilt"], row["as_erratum_says"], row["status"]) == (7.5, 7.0, "equal")


def test_the_nearest_of_several_errata_counts() -> None:
    ways = [ExplainedRow(k, "torque_mae", "A", np.full(6, x)) for k, x in ((3, 2.2), (4, 2.01))]
    told, *_ = compared(reference(), rebuilt([4.0] * 6), ways)
    assert (told["erratum"], told["as_erratum_says"], told["status"]) == (4, 2.01, "erratum 4")


def test_a_study_without_the_recording_compares_nothing() -> None:
    assert [*compared(reference(recording="elsewhere"), rebuilt([1.0] * 6), [])] == []


def test_a_row_that_cannot_be_rebuilt_stands_with_its_print_alone() -> None:
    rows = [*compared(reference(values={"old": (2.0,) * 6}), rebuilt([2.0] * 6), [])]
    assert [(row["number"], row["printed"]) for row in rows] == [(k, 2.0) for k in range(1, 7)]
    assert all(np.isnan(row["rebuilt"]) and row["status"] == "unexplained" for row in rows)


def test_what_is_right_stands_beside_and_rows_may_stand_elsewhere() -> None:
    right = {"table": "torque_mae", "value": {"A": "max"}, "where": {"model": "A"}}
    rows = compared(
        reference(right=right, sources={"A": "Table 2"}), rebuilt([2.0, 1, 1, 1, 1, 1]), []
    )
    first = next(rows)
    assert (first["source"], first["right"]) == ("Table 2", 6.0)


def test_what_is_right_may_be_a_fit_to_other_recordings() -> None:
    """Of an arm, and so without a recording; its rows have names of their own."""
    fitted = [
        {"robot": robot, "joint": joint, "parameter": parameter, "value": joint + add}
        for robot, parameter, add in (("ur5", "k", 1), ("ur5", "other", 10), ("ur10e", "k", 100))
        for joint in range(1, 7)
    ]
    where = {"robot": "ur5", "parameter": {"A": "k"}}
    one = reference(right={"table": "fit", "value": "value", "where": where})
    rows = compared(one, rebuilt([2.0] * 6) | {"fit": pd.DataFrame(fitted)}, [])
    assert [row["right"] for row in rows] == [2, 3, 4, 5, 6, 7]


def test_a_row_has_six_numbers_or_one() -> None:
    with pytest.raises(ValueError, match="six, or one"):
        reference(values={"A": (1.0, 2.0)})


def of_page(rows: list[dict]) -> Shown:
    """What the page of the published numbers shows of these."""
    table = pd.DataFrame(rows, columns=PRINTED_COLUMNS)
    table = table.astype({"as_erratum_says": float, "erratum": float, "right": float})
    return section("thesis", Results({"reference": THESIS.name}, {"printed": table}), "published")


def test_unexplained_numbers_are_listed_and_all_are_in_the_table_of_their_source() -> None:
    rows = [*compared(reference(), rebuilt([2.0, 2.5, 2, 2, 2, 2]), [])]
    told = of_page([row | {"row": "F*"} for row in rows])
    assert "5 of 6 published numbers are rebuilt" in told.text
    assert told.tables["by-source"] == [
        {"published in": "Table 1", "numbers": "6", "rebuilt": "5", "explained by errata": "0"}
        | {"unexplained": "1"}
    ]
    (missed,) = told.tables["unexplained"]
    assert (missed["published in"], missed["row"], missed["place"]) == ("Table 1", "F̂*", "joint 2")
    assert (missed["by"], missed["off by"]) == ("rebuilt", "+25 %")
    first, *others = told.tables["every-Table-1"]
    assert [*first.values()][:6] == ["torque_mae", "F̂*", "1", "2.0001", "2", "1.000"]
    assert len(others) == 5


def test_the_nearest_explanation_tells_the_per_cent() -> None:
    known = [ExplainedRow(1, "torque_mae", "A", np.full(6, 1.8))]
    rows = [*compared(reference(), rebuilt([np.nan] * 6), known)]
    listed = of_page(rows).tables["unexplained"]
    assert {(row["by"], row["off by"]) for row in listed} == {("erratum 1", "−10 %")}


def test_what_errata_of_the_thesis_explain_is_printed() -> None:
    thesis = read_reference(THESIS)
    for erratum in thesis.errata:
        for way in erratum.explains:
            assert way.row in dict(thesis.printed[way.printed].values)
            assert (way.closed_loop is None) != (way.acceleration is None)
    assert thesis.explained() <= thesis.recordings()
    accelerated = thesis.explained_accelerations().keys()
    assert accelerated == {"Movement_No9_Singularity_Free_NoDist"}


@pytest.fixture(scope="module")
def slow(real_ur5: RealStudy) -> RealRecording:
    return real_ur5.recording("Movement_No5_Acc_slow_no_disturbance")


@pytest.mark.parametrize("model", ["A", "C"])
def test_without_changes_an_error_is_that_of_the_tables(slow: RealRecording, model: str) -> None:
    """Of torques and velocities; a massless arm leaves all of the controller's torque."""
    tracking = tracking_of(slow.signals)
    moment, qd = slow.signals.target_moment, slow.signals.actual_qd
    assert tracking is not None
    assert moment is not None
    assert qd is not None
    loop = simulated(slow.signals, slow.robot, tracking, published_gains(slow.robot))

    def error(quantity: str, **changes: object) -> np.ndarray:
        way = LoopError.model_validate(
            {"quantity": quantity, "gains": model, "model": model} | changes
        )
        return loop_error(slow.robot, slow.signals, way)

    np.testing.assert_allclose(error("qd"), mean_absolute_error(loop.qd[model], qd))
    np.testing.assert_allclose(error("torque"), mean_absolute_error(loop.torque[model], moment))
    still = error("torque", masses=dict.fromkeys(range(1, 7), 0))
    zero = mean_absolute_error(np.zeros_like(moment), moment)
    np.testing.assert_allclose(still[1:4], zero[1:4], rtol=0.03)
    later = error("qd", from_s=20.0)
    rows = slow.signals.time >= 20
    np.testing.assert_allclose(later, mean_absolute_error(loop.qd[model][rows], qd[rows]))
    ends = (error("qd", places=(0.0, 1.0)), error("qd"))
    np.testing.assert_allclose(*ends, rtol=1e-2)


def test_gravity_begins_with_a_step_where_the_imu_is_filtered_before_it_is_rotated() -> None:
    """An arm at rest: its IMU reads gravity alone, which the filter from rest reaches late."""
    robot, time = load_robot(robot_path("ur5")), 0.008 * np.arange(750)
    q = np.tile([0.3, -1.2, 1.1, -1.3, -1.5, 0.2], (len(time), 1))
    rotation, origin, jacobian = flange_kinematics(robot, q)
    still = {"time": time, "segment": np.zeros(len(time), dtype=int)}
    signals = Signals(
        **still, interpolated=np.zeros(len(time), dtype=bool), actual_q=q, actual_qd=0 * q
    )
    kinematics = Kinematics(
        time=time,
        origin=origin,
        rotation=rotation,
        jacobian=jacobian,
        smallest_singular_value=np.ones(len(time)),
    )
    reading = np.hstack([[0, 0, 9.81] @ rotation[0], np.zeros(3)])
    imu = pd.DataFrame(np.tile(reading, (len(time), 1)), columns=SENSOR_COLUMNS["imu"])
    imu.insert(0, "time", time)
    quality, way = (
        Quality(starts={"imu": StartOffset(0.0, 0.01)}),
        AccelerationError(model_delay_s=0.08),
    )
    own = AlignedRecording(signals=signals, kinematics=kinematics, imu=imu, quality=quality)
    modelled, felt = explained_accelerations(own, robot, way)
    assert modelled == pytest.approx(np.zeros_like(modelled), abs=1e-9)
    assert felt[0] == pytest.approx([0, 0, -9.81, 0, 0, 0], abs=1e-3)
    assert felt[-100] == pytest.approx(np.zeros(6), abs=1e-3)
    data = euler_figure(signals, felt, modelled).data
    assert data["IMU, az [m/s²]"].min() == pytest.approx(-9.81, abs=0.01)
