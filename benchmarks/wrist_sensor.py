"""What the audit of a wrist sensor finds, seed by seed, and how often its intervals hold.

A simulated UR5e hangs from a ceiling and carries a tool of 1.2 kg. Its wrist sensor is biased,
drifts, is turned by 5° and reads 3 % too little. Two recordings are fitted to; each seed draws the
motion, the noise and the contacts of one more, in which the tool is pushed. One table counts the
intervals that hold the truth. It runs in a folder of its own, by `snakemake`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from benchmarks.harness.options import asked
from ur5lib.tables import read_csv
from ur5lib.workspace.new import new_workspace

SEEDS, SECONDS = 20, 60.0
TOOL: dict[str, Any] = {
    "mass": 1.2,
    "center_of_mass": [0.01, -0.02, 0.05],
    "inertia": [0.002] * 2 + [0.001] + [0] * 3,
}
SENSOR: dict[str, Any] = {
    "bias": [3.0, -3.0, 3.0, 0.1, -0.1, 0.1],
    "drift_per_min": [0.5, -0.5, 0.5, 0.02, -0.02, 0.02],
    "rotation_deg": [3.0, 0.0, 4.0],
    "scale": 0.97,
}
AXES, COMPONENTS = [*"xyz"], ["Fx", "Fy", "Fz", "nx", "ny", "nz"]
TRUTH = {
    **{("bias", name): value for name, value in zip(COMPONENTS, SENSOR["bias"], strict=True)},
    **{("drift", name): x for name, x in zip(COMPONENTS, SENSOR["drift_per_min"], strict=True)},
    **{("turn", axis): x for axis, x in zip(AXES, SENSOR["rotation_deg"], strict=True)},
    **{("scale", axis): SENSOR["scale"] for axis in AXES},
    **{("center_of_mass", a): x for a, x in zip(AXES, TOOL["center_of_mass"], strict=True)},
    ("mass", ""): TOOL["mass"],
    ("mass_by_currents", ""): TOOL["mass"],
}


def main() -> None:
    """Print the number of intervals that contain the truth, by quantity."""
    seeds, quick = asked(__doc__, SEEDS)
    seconds = 15.0 if quick else SECONDS
    with tempfile.TemporaryDirectory() as folder:
        own = study(seeds, seconds, fits=1 if quick else 2)
        rows = audited(Path(folder), own, cores="1" if quick else "all")
    print(f"{seeds} seeds of {seconds:g} s")
    for quantity, part in rows.groupby("quantity", sort=False):
        inside = (part["low"] <= part["truth"]) & (part["truth"] <= part["high"])
        off = (part["value"] - part["truth"]).abs()
        print(
            f"{quantity:>16}: {inside.sum():>3} of {len(part):>3} intervals hold the truth "
            f"({inside.mean():.0%}), largest error {off.max():.2g} {part['unit'].iloc[0]}"
        )


def study(seeds: int, seconds: float, fits: int) -> dict[str, Any]:
    """Return the study: `fits` recordings to fit, and a pushed one for each seed."""
    fitted = [planned(f"fit_{draw}", "fit", draw, seconds) for draw in range(101, 101 + fits)]
    pushed = [
        planned(f"seed_{seed}", "contact", seed, seconds, contacts=pushes(seed, seconds))
        for seed in range(seeds)
    ]
    arm = {"arm": "ur5e", "mounting": "ceiling", "tool": TOOL}
    return {"study": "wrist", "title": "Wrist", "robot": arm, "recordings": fitted + pushed}


def planned(name: str, role: str, draw: int, seconds: float, **more: Any) -> dict[str, Any]:
    """Return a recording that turns the tool to all sides."""
    motion = {"kind": "fourier", "draw": draw, "period_s": 20, "amplitude_rad": 1.2}
    plan = {"trajectory": motion | {"limit_share": 0.3}, "seconds": seconds, "seed": draw}
    return {
        "name": name,
        "format": "rtde-csv",
        "role": role,
        "simulate": plan | {"wrist_sensor": SENSOR} | more,
    }


def pushes(seed: int, seconds: float) -> list[dict[str, Any]]:
    """Return three pushes of two seconds in random directions."""
    random = np.random.default_rng(seed)
    return [
        {
            "kind": "push",
            "start_s": share * seconds,
            "force": random.uniform(-20, 20, 3).round(1).tolist(),
        }
        for share in (0.2, 0.45, 0.7)
    ]


def audited(folder: Path, study: dict[str, Any], cores: str) -> pd.DataFrame:
    """Return the audit's rows of the pushed recordings, each with its truth."""
    new_workspace(folder)
    (folder / "config.yaml").write_text(yaml.safe_dump(study))
    pushed = [one["name"] for one in study["recordings"] if one["role"] == "contact"]
    files = [f"results/wrist/recordings/{name}/audit.csv" for name in pushed]
    options = ["--quiet", "all", "--cores", cores]
    command = [sys.executable, "-m", "snakemake", *options, "--", *files]
    subprocess.run(command, cwd=folder, check=True)
    rows = pd.concat([read_csv(folder / file) for file in files], ignore_index=True)
    rows = rows.fillna({"component": ""})
    rows["truth"] = [
        TRUTH.get(key) for key in zip(rows["quantity"], rows["component"], strict=True)
    ]
    return rows.dropna(subset="truth")


if __name__ == "__main__":
    main()
