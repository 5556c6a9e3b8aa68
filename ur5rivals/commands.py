"""`ur5 leaderboard` and `ur5 replay`."""

from pathlib import Path
from typing import Annotated

import typer

from ur5lib.commands.arguments import ADDRESS_HELP, Results, print_lines
from ur5lib.study.address import results_folder

PANEL = "Others"


def leaderboard(
    results: Annotated[
        list[Path],
        typer.Argument(
            parser=results_folder, metavar="STUDY", help=f"studies that are built: {ADDRESS_HELP}"
        ),
    ],
    estimator: Annotated[
        str | None,
        typer.Option(
            help="one more, as module:Class of a file in this folder or of a package, or by its "
            "entry point (docs/outside.md)"
        ),
    ] = None,
) -> None:
    """Compare published estimators of the contact force with ours.

    Yours, too, and on your studies. Example: ur5 leaderboard thesis ur10e
    """
    from ur5rivals.board import TABLE_FILE
    from ur5rivals.board import leaderboard as compared

    typer.echo(compared(results, estimator))
    typer.echo(f"all figures: {TABLE_FILE}")


def replay(
    file: Annotated[Path, typer.Argument(help="model of the arm: MJCF or URDF")],
    results: Results,
    recording: Annotated[str, typer.Argument(help="one of its recordings")],
) -> None:
    """Replay a model along a recording in MuJoCo.

    Prints errors of torque, and of angles in a loop. Example: ur5 replay ur5e.xml mine pushed
    """
    from ur5rivals.replay import replayed

    print_lines(replayed(file, results, recording))
