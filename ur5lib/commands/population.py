"""`ur5 population`: what is known of a joint before its first recording, and from which arms."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import yaml

from ur5lib.datasets.catalogue import catalogue
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.identification import condition
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.population import KINDS, Population, fit_population, typical_arm
from ur5lib.pipeline.records.friction import Friction
from ur5lib.robots.description import POPULATION, joint_sizes
from ur5lib.robots.population import Measured, MeasuredArm, MeasuredJoint, Trait, read_measured
from ur5lib.tables import write_text
from ur5lib.timeseries.arrays import Array

CLEAR = 2.0  # standard errors, from which on a value's logarithm is nearly normal
HEAD = "# Torque constants and friction of measured arms, by `ur5 population --write`; SI units.\n"
AS_TORQUE = "currents from torques"  # finding of recordings of torques in place of currents
UNITS = condition.UNITS | {"torque_constant": "of the family's", "load": ""}


def population_lines(results: Sequence[Path], file: Path | None, write: Path | None) -> list[str]:
    """Return what is known of joints, and what the arms of further studies change.

    results: folders of built studies; file: of measured arms, by default the shipped one; write:
    where to write the arms of the studies alone.
    """
    new = [arm for folder in results for arm in measured_arms(FinishedStudy(folder))]
    if write is not None:
        if not new:
            raise InputError("--write needs results of studies in which friction was fitted")
        arms = Measured(arms=new).model_dump(exclude_none=True)
        write_text(
            HEAD + yaml.safe_dump(arms, sort_keys=False, default_flow_style=None, width=120), write
        )
        return [f"{write} written: {', '.join(f'{arm.arm} of {arm.study}' for arm in new)}"]
    known = read_measured(file or POPULATION)
    lines = [
        f"{arm.arm}: {len(arm.joints)} joints, {arm.days} day{'s' * (arm.days > 1)}, "
        f"{arm.minutes:g} min ({arm.source})"
        for arm in known.arms
    ]
    lines += ["", *_table(fit_population(known))]
    if new:
        studies = {arm.study for arm in new}
        kept = [arm for arm in known.arms if arm.study not in studies]
        lines += ["", f"with {', '.join(sorted(studies))}:", ""]
        lines += _table(fit_population(Measured(arms=[*kept, *new])))
    return lines


def measured_arms(study: FinishedStudy) -> Iterator[MeasuredArm]:
    """Yield the arms of a study that were fitted without a population, as far as it shows them.

    Without further terms of friction, too, as Coulomb and viscous friction beside them are others.
    """
    configuration = study.configuration()
    friction = configuration.settings.friction
    if friction.population != "none" or friction.terms:
        raise InputError(
            f"{study.folder} was fitted with a population, which it would count twice, or with "
            "terms that other arms lack; set settings: friction: {population: none, terms: []}, "
            "and run snakemake again"
        )
    for name in configuration.arms():
        fitted = study.parameters(Friction, name, "friction")
        if fitted.from_:
            yield _measured_arm(study, name, fitted)


def _measured_arm(study: FinishedStudy, name: str, friction: Friction) -> MeasuredArm:
    entries = [study.recording(recording) for recording in friction.from_]
    found = [study.quality(recording) for recording in friction.from_]
    as_torque = any(own.finding == AS_TORQUE for quality in found for own in quality.findings)
    configuration, motors = study.configuration(), study.arm(name)
    dataset = catalogue().get(configuration.study)
    family, joints = np.array(motors.family_torque_constants()), {}
    for joint, values in sorted(_values(friction, family if as_torque else None).items()):
        constant = family[joint - 1]
        joints[joint] = MeasuredJoint(
            torque_max=motors.motor(joint).torque_max,
            family_constant=None if np.isnan(constant) else round(constant, 3),
            values=values,
        )
    return MeasuredArm(
        arm=name,
        study=configuration.study,
        source=dataset.address if dataset else configuration.title,
        days=len({entry.date for entry in entries}),
        minutes=round(sum(quality.duration_s for quality in found) / 60, 1),
        joints=joints,
    )


def _values(friction: Friction, unit: Array | None) -> dict[int, dict[Trait, tuple[float, float]]]:
    """Return the determined traits of each joint whose current follows its torque.

    unit: (n,) [Nm/A], by which recorded torques became currents. They show no torque constant, and
    friction as it is in them, whatever torque the link model gives the same motion.
    """
    values: dict[int, dict[Trait, tuple[float, float]]] = {}
    scale = 1.0 if unit is None else unit / torque_constants(friction.fit)
    for name in KINDS:
        own = np.broadcast_to(1.0 if name == "load" else scale, len(friction.fit.joints))
        for row in friction.parameters:
            followed = friction.fit.joints[row.joint - 1].contradicted is None
            clear = not KINDS[name].logarithm or row.value > CLEAR * row.std_error
            shown = unit is None or name != "torque_constant"
            if row.name == name and row.determined and followed and clear and shown:
                found = own[row.joint - 1] * np.array([row.value, row.std_error])
                pair = float(f"{found[0]:.4g}"), float(f"{found[1]:.2g}")
                values.setdefault(row.joint, {})[name] = pair
    return values


def _table(population: Population) -> Iterator[str]:
    """Yield each trait by joint size, with its standard deviation for one more arm."""
    sizes = [size for size in joint_sizes() if size.startswith("size")]
    yield f"{'':16}" + "".join(f"{size.replace('size', 'size '):>16}" for size in sizes)
    torque_max = [joint_sizes()[size]["torque_max"] for size in sizes]
    typical = typical_arm(population, np.array(torque_max))
    for name, own in typical.items():
        std = np.sqrt(np.diag(own.covariance))
        cells = (f"{mean:.3g} ± {error:.2g}" for mean, error in zip(own.mean, std, strict=True))
        row = f"{name.replace('_', ' '):16}" + "".join(f"{cell:>16}" for cell in cells)
        spread = population[name]
        yield f"{row}  {UNITS[name]} ({spread.joints} joints of {spread.arms} arms)"
