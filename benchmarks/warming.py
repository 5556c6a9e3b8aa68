"""How much friction an arm that repeats one task loses per kelvin, from its currents alone.

    python -m benchmarks.warming <dataset_02052023.csv of UR3 CobotOps, doi 10.24432/C5J891>

Without positions, gravity is unknown, but along whole cycles its work is always the same: what
Σ i q̇ / Σ |q̇| [A] of blocks of cycles changes with a joint's temperature is friction. `--quick`
takes a made-up log instead, of joints that lose 1 % per kelvin.
"""

import numpy as np
import pandas as pd

from benchmarks.harness.options import options_of
from ur5lib.timeseries.arrays import Array, Labels

BLOCK = 6  # cycles


def change(current: Array, qd: Array, temperature: Array, block: Labels) -> tuple[float, float]:
    """Return friction's relative change [1/K] and its jackknife error; all (N,)."""
    sums = pd.DataFrame({"work": current * qd, "way": np.abs(qd), "warm": temperature * np.abs(qd)})
    work, way, warm = sums.groupby(block).sum().to_numpy().T
    columns = np.column_stack([way, warm - way * warm.sum() / way.sum()]) / np.sqrt(way)[:, None]
    every = np.arange(len(way))
    kept = [every, *(np.delete(every, one) for one in every)]
    fits = [np.linalg.lstsq(columns[own], (work / np.sqrt(way))[own])[0] for own in kept]
    whole, *left = [gained / usual for usual, gained in fits]
    return whole, float(np.sqrt(len(every) - 1) * np.std(left))


def main() -> None:
    """Print the change of each joint's friction, and the mean."""
    options = options_of(__doc__)
    options.add_argument("log", nargs="?", help="dataset_02052023.csv")
    given = options.parse_args()
    *kinds, block = made_up() if given.quick else read(given.log)
    found = np.array([change(*own, block) for own in zip(*(k.T for k in kinds), strict=True)]) * 100
    for joint, (value, error) in enumerate(found, 1):
        print(f"| joint {joint} | {value:.2f} ± {error:.2f} %/K |")
    weight = found[:, 1] ** -2.0
    print(f"| all | {weight @ found[:, 0] / weight.sum():.2f} ± {weight.sum() ** -0.5:.2f} %/K |")


def read(path: str) -> tuple[Array, Array, Array, Labels]:
    """Return currents [A], speeds [rad/s] and temperatures [°C] (N, 6), and blocks (N,)."""
    log = pd.read_csv(path, sep=";", decimal=",").rename(columns=str.strip)
    kinds = [log.filter(regex=f"^{kind}_[JT]") for kind in ("Current", "Speed", "Temperature")]
    whole = np.isfinite(np.hstack(kinds)).all(axis=1)
    block = (log["cycle"].diff() != 0).cumsum().to_numpy() // BLOCK
    return *(kind.to_numpy()[whole] for kind in kinds), block[whole]


def made_up() -> tuple[Array, Array, Array, Labels]:
    """Return the same of two hours, 43 °C on average."""
    time, random = np.arange(7200.0)[:, None], np.random.default_rng(0)
    qd, temperature = np.sin(time * random.uniform(0.8, 1.2, 6)), 45 - 15 * np.exp(-time / 1200)
    friction = (0.5 * np.sign(qd) + 0.2 * qd) * (1 - 0.01 * (temperature - 43))
    current = friction + np.cos(time) + 0.05 * random.standard_normal(qd.shape)
    return current, qd, temperature + 0 * qd, time[:, 0].astype(int) // 150


if __name__ == "__main__":
    main()
