"""What simulated recordings tell, and whether intervals hold the truth."""

from pathlib import Path

import numpy as np
import pytest
import torch

from benchmarks.harness.stand import fitted_map, plans, taken

pytestmark = pytest.mark.slow

torch.set_num_threads(1)


@pytest.mark.xfail(
    strict=True,
    reason="0.7, 1.7 and 2.2 % on joints 2 to 4, 9 and 12 % on joints 5 and 6: friction reverses "
    "over one distance, half of the stand's, with which forces on real arms are better",
)
def test_torque_constants_are_not_missed_in_one_direction(tmp_path: Path) -> None:
    """Without noise. Were friction to turn at once, joint 3's would be 3 % too large, and those of
    joints 5 and 6 by 15 and 20 %. Joint 1's is 1.4 % too small, instead of 0.3 %: what real arms
    show at rest, and the stand does not, hides that its friction is periodic.
    """
    drawn = enumerate(plans(seed=0, seconds=14)[:3])
    study = [taken(plan | {"noise": False}, tmp_path / str(k)) for k, plan in drawn]
    fitted = [row.value for row in fitted_map(study).parameters if row.name == "torque_constant"]
    error = np.abs(fitted / study[0].summary.drive.torque_constant - 1)
    assert error[0] < 0.02
    assert error[1:4].max() < 0.01
    assert error[4:].max() < 0.04
