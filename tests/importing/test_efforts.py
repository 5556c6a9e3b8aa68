"""What columns of a log without a known name are: currents in a driver's unit, and targets."""

from pathlib import Path

import numpy as np
import pytest

from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import FileClocks
from ur5lib.importing.contents import FileContents, TableHeader
from ur5lib.importing.efforts import as_amperes, name_efforts
from ur5lib.importing.identity import ArmIdentity
from ur5lib.timeseries.arrays import Array, Labels

UNKNOWN_ARM = ArmIdentity("", None, tuple(range(6)))
STEP = 1e-3  # A, of a controller's currents
CONSTANTS = np.array([-12.925, -13.088, 9.358, 4.572, -4.572, 4.548])  # Nm/A, of a driver


def block(rows: Array, first: int = 1, named: bool = True) -> ColumnBlock:
    """Columns without a name, but with a unit, as of a table whose header tells no more."""
    unit = " [A]" if named else ""
    names = tuple(f"column {first + k}{unit}" for k in range(rows.shape[1]))
    return ColumnBlock(names, rows, "rows")


# Currents that a driver multiplied by constants of its own


def counts(largest: int = 1500, rows: int = 4000) -> Labels:
    """Whole numbers (N, 6) up to a largest one, which occurs."""
    drawn = np.random.default_rng(0).integers(-largest, largest + 1, (rows, 6))
    drawn[0] = largest
    return drawn


@pytest.mark.parametrize("gaps", [(1,), (0, 2), (0, 3)])
def test_rounded_currents_come_back_from_any_constants(gaps: tuple[int, ...]) -> None:
    """Also where no two levels are neighbours, but two or three steps apart, and never nearer."""
    whole = counts()
    kept = np.isin(np.abs(whole) % (2 * gaps[-1] + 1), gaps) if len(gaps) > 1 else whole > 0
    whole = np.where(kept, whole, 0)
    written = CONSTANTS * STEP * whole + 1e-9 * np.random.default_rng(1).normal(size=whole.shape)
    found = as_amperes(block(written, named=False))
    np.testing.assert_allclose(found.rows, np.sign(CONSTANTS) * STEP * whole, atol=1e-7)


def test_decimals_are_no_constants() -> None:
    """One column of a power of ten is enough, and no other number is near enough to one."""
    step = 0.01
    constants = CONSTANTS.copy()
    for near, told in ((1.0, False), (1.00001, False), (1.001, True)):
        constants[3] = near * step / STEP
        rows = constants * STEP * counts()
        assert (as_amperes(block(rows, named=False)).rows is not rows) == told


@pytest.mark.parametrize("factor", [0.2, 5.0])
def test_steps_of_a_converter_are_no_constants(factor: float) -> None:
    """Nor are those that no motor has."""
    scaled = factor * CONSTANTS * STEP * counts()
    assert as_amperes(block(scaled, named=False)).rows is scaled


@pytest.mark.parametrize(
    ("largest", "told"),
    [(100, False), (101, True), (99_999, True), (100_000, False)],
)
def test_a_current_reaches_a_hundred_to_a_hundred_thousand_of_its_steps(
    largest: int, told: bool
) -> None:
    whole = counts(largest)
    whole[1:100] = np.arange(1, 100)[:, None]  # neighbours, wherever the others are
    rows = CONSTANTS * STEP * whole
    assert (as_amperes(block(rows, named=False)).rows is not rows) == told


@pytest.mark.parametrize(("off", "told"), [(0.008, True), (0.02, False)])
def test_numbers_off_the_multiples_by_a_hundredth_are_not_rounded(off: float, told: bool) -> None:
    whole = counts().astype(float)
    whole[np.abs(whole) == 1500] *= 1 + off / 1500  # the largest, which no step is told by
    rows = CONSTANTS * STEP * whole
    assert (as_amperes(block(rows, named=False)).rows is not rows) == told


def test_other_arms_have_no_such_driver() -> None:
    rows = CONSTANTS[:5] * STEP * counts()[:, :5]
    assert as_amperes(block(rows, named=False)).rows is rows


# Targets without a name


def channels(*blocks: ColumnBlock) -> dict[str, ColumnBlock]:
    """The channels of efforts in a file without a motion."""
    clocks = FileClocks({"rows": np.arange(float(len(blocks[0].rows)))}, {})
    file = FileContents(Path("log.csv"), "table-csv", TableHeader(), [*blocks], [], clocks, [])
    return name_efforts({str(k): one for k, one in enumerate(blocks)}, None, UNKNOWN_ARM, file)


@pytest.mark.parametrize("sizes", [[1.0] * 6, [50.0] * 6, [1, 1, 1, 1, 9, 9], [1, 9, 9, 9, 9, 9]])
@pytest.mark.parametrize(("noise_share", "is_target"), [(0.27, True), (0.33, False)])
def test_a_nameless_effort_is_a_target_if_it_is_smooth_beside_the_roughest(
    noise_share: float, is_target: bool, sizes: list[float]
) -> None:
    """With less than 0.3 of its noise, joint by joint for their size, whatever that is."""
    random, phase = np.random.default_rng(1), np.linspace(0, 60, 20_000)[:, None] + np.arange(6)
    noise = 0.01 * random.normal(size=phase.shape)
    measured = np.sin(phase) + noise
    smoother = np.array(sizes) * (np.sin(phase) + noise_share * noise)
    found = channels(block(measured), block(smoother, first=7))
    assert (found.get("target_current") is not None) == is_target
    assert found["actual_current"].names[0] == "column 1 [A]"
    assert len(found) == 1 + is_target


@pytest.mark.parametrize(("peak", "factor"), [(59.0, 1.0), (61.0, 1e-3)])
def test_currents_beyond_those_of_any_arm_are_milliamperes(peak: float, factor: float) -> None:
    rows = peak * np.sin(np.linspace(0, 9, 1000))[:, None] * np.ones(6)
    rows[:, 0] = peak
    (found,) = channels(block(rows)).values()
    np.testing.assert_allclose(found.rows, factor * rows)
