"""What force sensors read where no friction was fitted, and what the forces rest on there."""

from collections.abc import Iterator

from ur5lib.force.static_estimate import BREAKAWAY, LEAST_ERROR, SLOW
from ur5lib.report.cells import fixed
from ur5lib.report.contents import MOST_SHOWN
from ur5lib.report.results import Results


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"]
    rows = rows[rows["contacts"] > 0].sort_values("largest_force_n", ascending=False)
    return [*rows["recording"]]


def readings(results: Results) -> Iterator[str]:
    """Report largest force and share in contact by sensor, where no friction was fitted."""
    if len(results.tables["friction"]):
        return
    for row in results.tables["sensed"][:MOST_SHOWN].itertuples():
        yield (
            f"On {row.recording}, the force sensor reads at most {fixed(row.largest_force_n, 1)} "
            f"N, and a contact in {fixed(100 * row.share_in_contact, 0)} % of the time."
        )


def uncalibrated(results: Results) -> Iterator[str]:
    """Say what the static estimate rests on, where it stands for a fit."""
    if (results.tables["force_mae"]["estimate"] == "static").any():
        yield (
            "No friction was fitted to this arm. The static estimate of the force is therefore not "
            f"calibrated: it takes the maker's torque constants, with an error of "
            f"{100 * LEAST_ERROR:.0f} %, the weight of the declared arm and its payload, and any "
            f"friction up to {100 * BREAKAWAY:.0f} % of each motor's largest torque, and is known "
            f"only while all joints are slower than {SLOW:g} rad/s. Its 95 % band is wide."
        )
