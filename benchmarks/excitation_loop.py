"""The loop of `ur5 excite`: design, record on the virtual test stand, identify, design the next.

    python -m benchmarks.excitation_loop [<robot>] [--precision 0.3] [--quick]

The first motion is designed for all parameters of the arm as it is, each next one for what is still
undetermined, with a known load on the flange. The loop ends when every standard error is at most a
share of what was known before any recording, or after some recordings. Printed are the parameters
that are least determined before each next recording, with the standard errors that were predicted
and those that the study then states. The study is built in results/excitation-loop.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from benchmarks.harness.options import options_of
from benchmarks.study import snakemake
from ur5lab.excitation.design import USUAL_EFFORT, Effort
from ur5lab.excite import ExciteOptions, excite, known_load
from ur5lib.excitation.outlook import KEPT_COEFFICIENTS
from ur5lib.excitation.problem import JOINT_PARAMETERS
from ur5lib.records.friction import Friction
from ur5lib.tables import read_json, read_record

STUDY = "excitation-loop"
RESULTS = Path("results") / STUDY
LOAD = (2.0, 0.06, 0.0, 0.05)  # kg, m: beside the axis of joint 6
PRECISION, MOST = 0.3, 3  # share of the prior's standard error, recordings
SECONDS = 20.0
QUICK = Effort(1, 0, ((1e2, 30), (1e4, 20)))
SHOWN = 6
IDENTIFIED = "fit_friction"  # the last step that the next design needs


def main() -> None:
    """Print what each recording of the loop determines."""
    options = options_of(__doc__)
    options.add_argument("robot", nargs="?", default="ur5e", help="name of an arm")
    options.add_argument("--precision", type=float, default=PRECISION, help="share of the prior's")
    given = options.parse_args()
    effort, most = (QUICK, 2) if given.quick else (USUAL_EFFORT, MOST)
    recordings: list[dict[str, Any]] = []
    before: dict[str, float] = {}
    for number in range(1, most + 1):
        predicted = designed(given.robot, number, effort)
        recordings.append(recording(number))
        built(recordings)
        after = stated(given.robot)
        print_recording(number, predicted, before, after)
        prior = {row["parameter"]: row["std_error_prior"] for row in predicted}
        largest = max(after[name] / prior[name] for name in after)
        print(f"largest standard error: {largest:.0%} of the prior's")
        if largest <= given.precision:
            break
        before = after


def designed(robot: str, number: int, effort: Effort) -> list[dict[str, Any]]:
    """Write the files of the next motion; return the predicted standard errors."""
    options = ExciteOptions(robot, SECONDS, "model", None, None, None, number)
    if number > 1:
        load = known_load(*LOAD)
        options = replace(options, question="undetermined", results=RESULTS, payload=load)
    for line in excite(options, folder_of(number), effort):
        print(line)
    found: list[dict[str, Any]] = read_json(folder_of(number) / "excitation.json")["parameters"]
    return found


def folder_of(number: int) -> Path:
    """Return the folder of a motion's files."""
    return RESULTS / "designs" / str(number)


def recording(number: int) -> dict[str, Any]:
    """Return the entry of a motion in the study, with noise of its own."""
    study = yaml.safe_load((folder_of(number) / "stand.yaml").read_text())
    entry = study["recordings"][0] | {"name": f"designed_{number}"}
    entry["simulate"]["seed"] = number
    return dict(entry)


def built(recordings: list[dict[str, Any]]) -> None:
    """Simulate and identify, without the steps of forces and report."""
    study = {"study": STUDY, "title": "Designed recordings", "recordings": recordings}
    file = RESULTS / "configuration.yaml"  # `ur5 excite` reads it there
    file.write_text(yaml.safe_dump(study, sort_keys=False, default_flow_style=None))
    snakemake(study, "--until", IDENTIFIED)


def stated(robot: str) -> dict[str, float]:
    """Return the standard errors of torque constants and friction that the study states."""
    rows = read_record(Friction, RESULTS / "parameters" / robot / "friction.json").parameters
    told = dict(zip(KEPT_COEFFICIENTS, JOINT_PARAMETERS, strict=True))
    return {
        f"{told[row.name]} of joint {row.joint}": row.std_error for row in rows if row.name in told
    }


def print_recording(
    number: int,
    predicted: list[dict[str, Any]],
    before: dict[str, float],
    after: dict[str, float],
) -> None:
    """Print the standard errors predicted for a recording, and those of the study."""
    print(f"recording {number}: standard errors, least determined first")
    print(f"{'':>30}{'predicted':>22}{'stated by the study':>22}")
    rows = [row for row in predicted if row["parameter"] in after]
    rows.sort(key=lambda row: -row["std_error_before"] / row["std_error_prior"])
    for row in rows[:SHOWN]:
        name = row["parameter"]
        told = f"{row['std_error_before']:.3g} -> {row['std_error_after']:.3g}"
        found = f"{before.get(name, row['std_error_prior']):.3g} -> {after[name]:.3g}"
        print(f"{name:>30}{told:>22}{found:>22} {row['unit']}")


if __name__ == "__main__":
    main()
