"""The command `ur5`."""

from pathlib import Path
from typing import Annotated

import typer

from ur5lib.errors import InputError

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
    from ur5lib.check import print_findings

    if print_findings(study):
        raise SystemExit(1)


@app.command()
def export(
    robot: Annotated[str, typer.Option(help="an arm described in ur5lib/robots, e.g. ur5")],
    model: Annotated[str, typer.Option(help="one of its models, e.g. C")],
    to: Annotated[str, typer.Option(help="the format: urdf")] = "urdf",
) -> None:
    """Print an arm under one of its models, for other engines; URDF knows no rotor inertias."""
    from ur5lib.robots.description import load_robot, robot_names, robot_path
    from ur5lib.robots.inertia import rigid_bodies
    from ur5lib.robots.urdf import urdf

    if to != "urdf":
        raise InputError(f"no format {to!r}; known: urdf")
    if robot not in robot_names():
        raise InputError(f"no arm {robot!r}; known: {', '.join(robot_names())}")
    arm = load_robot(robot_path(robot))
    if model not in arm.models:
        raise InputError(f"{robot} has no model {model!r}; known: {', '.join(arm.models)}")
    typer.echo(urdf(arm, rigid_bodies(arm, model)))


@app.command()
def schema() -> None:
    """Print the JSON schema of a study (workflow/study.schema.json)."""
    from ur5lib.study import schema_text

    typer.echo(schema_text(), nl=False)


def main() -> None:
    """Run the command; a wrong input is told in one sentence and ends with status 1."""
    try:
        app()
    except InputError as error:
        typer.echo(f"ur5: {error}", err=True)
        raise SystemExit(1) from error
