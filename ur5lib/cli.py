"""The command `ur5`."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ur5lib.errors import InputError

if TYPE_CHECKING:
    from ur5lib.robots.description import Robot

app = typer.Typer(
    help="Dynamics, friction and contact force of Universal Robots arms, from recordings.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.command()
def fetch(
    dataset: Annotated[str, typer.Argument(help="a published data set: thesis")],
    source: Annotated[
        Path | None, typer.Option("--from", help="copy from this folder instead of the network")
    ] = None,
    target: Annotated[
        Path | None, typer.Option("--to", help="folder to fill; raw/<dataset> if not given")
    ] = None,
) -> None:
    """Fetch a published data set into raw/, and verify every file."""
    from ur5lib.datasets import DATASETS
    from ur5lib.datasets import fetch as fetch_dataset

    if dataset not in DATASETS:
        raise InputError(f"no data set {dataset!r}; known: {', '.join(DATASETS)}")
    folder = target or Path("raw") / dataset
    added = fetch_dataset(DATASETS[dataset], folder, source)
    total = len(DATASETS[dataset].checksums)
    typer.echo(f"{folder}: {total} files verified, {added} of them new")


@app.command()
def check(
    study: Annotated[Path, typer.Argument(help="the study's configuration, e.g. config.yaml")],
) -> None:
    """Read and repair every recording of a study, and print what was found in it."""
    from ur5lib.study.check import print_findings

    if print_findings(study):
        raise SystemExit(1)


@app.command()
def export(
    robot: Annotated[str, typer.Option(help="an arm described in ur5lib/robots, e.g. ur5")],
    model: Annotated[str, typer.Option(help="one of its models, e.g. C")],
    to: Annotated[str, typer.Option(help="the format: urdf")] = "urdf",
) -> None:
    """Print an arm under one of its models, for other engines; URDF knows no rotor inertias."""
    from ur5lib.robots.inertia import rigid_bodies
    from ur5lib.robots.urdf import urdf

    if to != "urdf":
        raise InputError(f"no format {to!r}; known: urdf")
    arm = _load(robot)
    if model not in arm.models:
        raise InputError(f"{robot} has no model {model!r}; known: {', '.join(arm.models)}")
    typer.echo(urdf(arm, rigid_bodies(arm, model)))


@app.command()
def singularities(
    robot: Annotated[str, typer.Option(help="an arm described in ur5lib/robots, e.g. ur5")],
    within: Annotated[
        list[str] | None,
        typer.Option(help="range of a joint in rad, e.g. 3=0.2:2.8; whole turns where not given"),
    ] = None,
    count: Annotated[int, typer.Option(help="positions to try", min=1, max=1_000_000)] = 10_000,
    least: Annotated[float, typer.Option(help="singular below this singular value", min=0)] = 0.01,
) -> None:
    """Print how much of some joint ranges is near a shoulder, elbow or wrist singularity."""
    from rich.console import Console

    from ur5lib.dynamics.flange import flange_kinematics
    from ur5lib.force.singularities import map_singularities, sample_joints

    arm = _load(robot)
    q = sample_joints([_range(joint, within or []) for joint in range(1, 7)], count)
    with Console(stderr=True).status(f"trying {count} positions"):
        found = map_singularities(arm, q, flange_kinematics(arm, q)[2], least)
    for kind, share in found.share.items():
        typer.echo(f"{kind}: {100 * share:.2f} % of {count} positions are singular")
    worst = found.sigma_min.argmin()
    place = ", ".join(f"{angle:.3f}" for angle in found.q[worst])
    typer.echo(f"smallest singular value: {found.sigma_min[worst]:.2g}, at q = {place} rad")


def _load(robot: str) -> "Robot":
    from ur5lib.robots.description import load_robot, robot_names, robot_path

    if robot not in robot_names():
        raise InputError(f"no arm {robot!r}; known: {', '.join(robot_names())}")
    return load_robot(robot_path(robot))


def _range(joint: int, within: list[str]) -> tuple[float, float]:
    """Of a joint, from entries such as 3=0.2:2.8."""
    low, high = -math.pi, math.pi
    for entry in within:
        try:
            name, limits = entry.split("=")
            first, last = map(float, limits.split(":"))
            if not (1 <= int(name) <= 6 and first < last):
                raise ValueError
        except ValueError as error:
            raise InputError(f"--within {entry!r}: give joint=low:high, e.g. 3=0.2:2.8") from error
        if int(name) == joint:
            low, high = first, last
    return low, high


@app.command()
def schema() -> None:
    """Print the JSON schema of a study (workflow/study.schema.json)."""
    from ur5lib.study.model import schema_text

    typer.echo(schema_text(), nl=False)


@app.command()
def settings() -> None:
    """Print every setting of a study with its default (docs/settings.md)."""
    from ur5lib.study.settings_table import settings_text

    typer.echo(settings_text(), nl=False)


def main() -> None:
    """Run the command; a wrong input is told in one sentence and ends with status 1."""
    try:
        app()
    except InputError as error:
        typer.echo(f"ur5: {error}", err=True)
        raise SystemExit(1) from error
