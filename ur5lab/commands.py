"""`ur5 record`, `ur5 excite` and `ur5 live`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from ur5lib.commands.arguments import ADDRESS_HELP, Results, print_lines
from ur5lib.study.address import results_folder, study_file

PANEL = "Lab"
QUESTION = Literal["model", "undetermined", "friction", "payload", "force-bands"]


def record(
    study: Annotated[
        Path,
        typer.Argument(
            parser=study_file, metavar="STUDY", help=f"a study with `devices`: {ADDRESS_HELP}"
        ),
    ],
    name: Annotated[str, typer.Argument(help="name of the recording")],
    role: Annotated[Literal["fit", "validate", "contact"], typer.Option()] = "contact",
    seconds: Annotated[
        float | None, typer.Option(help="length; default: until the motion ends or Ctrl-C", min=1)
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="DEVICE", help="force_sensor or imu of the study, not to be recorded"),
    ] = None,
    move: Annotated[
        Path | None,
        typer.Option(
            help="a motion: CSV of six angles [rad], or a time [s] and six angles a line; or "
            "URScript's movej, movel and sleep"
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option(help="share of the motion's speed", min=0.01, max=1.0)
    ] = 0.25,
    wait: Annotated[
        float, typer.Option(help="least time [s] between the beginnings of two commands", min=0)
    ] = 0.0,
    by_hand: Annotated[bool, typer.Option("--by-hand", help="lead the arm by hand")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="move without asking")] = False,
    add: Annotated[bool, typer.Option("--add", help="append the entry to the study")] = False,
    emulate: Annotated[
        bool,
        typer.Option(
            "--emulate", help="record a simulated arm, force sensor and IMU, for practice"
        ),
    ] = False,
) -> None:
    """Record arm, force sensor and IMU together into raw/.

    The study's entry is printed. Example: ur5 record lab.yaml pushed --seconds 12 --emulate
    """
    from ur5lab.record import RecordOptions, record
    from ur5lib.commands.console import text_console

    without_these = tuple(without or ())
    options = RecordOptions(
        name, role, seconds, without_these, move, by_hand, speed, wait, yes, add, emulate
    )
    if record(study, options, text_console()):
        raise SystemExit(1)


def excite(
    robot: Annotated[str, typer.Option(help="name of an arm in ur5lib/robots, e.g. ur5e")],
    output: Annotated[Path, typer.Option("--output", "-o", help="folder to write to")],
    seconds: Annotated[float, typer.Option(help="length of the motion", min=5, max=60)] = 20.0,
    question: Annotated[
        QUESTION | None,
        typer.Option(
            help="what to determine; default: undetermined with --results, otherwise model"
        ),
    ] = None,
    results: Annotated[
        Path | None,
        typer.Option(
            parser=results_folder,
            metavar="STUDY",
            help=f"a study that recorded this arm before: {ADDRESS_HELP}",
        ),
    ] = None,
    table: Annotated[
        float,
        typer.Option(help="height in the base frame of the table or floor below the arm [m]"),
    ] = 0.0,
    boxes: Annotated[
        Path | None, typer.Option(help="YAML list of boxes around the arm (docs/excitation.md)")
    ] = None,
    payload: Annotated[
        tuple[float, float, float, float] | None,
        typer.Option(
            help="known load on the flange: mass [kg], centre of mass in frame 6 [m]",
            metavar="MASS X Y Z",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="seed of the search", min=0)] = 0,
) -> None:
    """Design the motion that best determines an arm's parameters.

    It keeps limits and avoids obstacles. Example: ur5 excite --robot ur5e -o raw/mine/designed
    """
    from ur5lab.excite import ExciteOptions, excite, known_load

    load = None if payload is None else known_load(*payload)
    chosen = question or ("model" if results is None else "undetermined")
    print_lines(
        excite(ExciteOptions(robot, seconds, chosen, results, table, boxes, seed, load), output)
    )


def live(
    results: Results,
    host: Annotated[str, typer.Option(help="address of the arm's controller")],
    robot: Annotated[
        str | None, typer.Option(help="arm of the study, where it has several")
    ] = None,
    as_in: Annotated[
        str, typer.Option(help="recording whose payload and mounting the arm has")
    ] = "",
    seconds: Annotated[
        float | None, typer.Option(help="length; default: until the arm's stream ends or Ctrl-C")
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="file of what is stated")] = Path(
        "live_forces.parquet"
    ),
) -> None:
    """State the contact force of a running arm, and write it.

    Currents show it; nothing is moved. Example: ur5 live mine --host 192.168.1.10
    """
    from ur5lab.live import Stream, live
    from ur5lib.commands.console import text_console

    ended = live(results, robot, as_in, Stream(host, seconds), output, text_console())
    print_lines([ended.in_words()])
    if ended.failed:
        raise SystemExit(1)
