"""The command-line interface `ur5`."""

import os
import shlex
import signal
import sys
from itertools import takewhile
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Any

import typer

from ur5lib import __version__
from ur5lib.commands.arguments import (
    ADDRESS_HELP,
    STUDY_HELP,
    Results,
    StudyFile,
    print_lines,
    results_folder,
)
from ur5lib.errors import InputError, printable, unknown
from ur5lib.workspace.beside import commands_beside

PANELS = "Start", "Lab", "Results", "Arm", "Project"
ArmName = Annotated[str, typer.Option(help="name of an arm in ur5lib/robots, e.g. ur5")]


class Panels(typer.core.TyperGroup):
    """Commands, listed by what they are for."""

    def format_commands(self, _: Any, formatter: Any) -> None:
        """Write a section for each of PANELS, with its commands in the order of definition."""
        panels: dict[str, list[tuple[str, str]]] = {panel: [] for panel in PANELS}
        for name, command in self.commands.items():
            row = name, command.get_short_help_str(200)
            panels[vars(command)["rich_help_panel"]].append(row)
        for panel, rows in filter(itemgetter(1), panels.items()):
            with formatter.section(panel):
                formatter.write_dl(rows)


app = typer.Typer(
    cls=Panels,
    help="Dynamics, friction and contact force of Universal Robots arms, from recordings.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,  # markup would take units, [s], for its own
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"ur5lib {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="the version")
    ] = False,
    no_extensions: Annotated[
        bool,
        typer.Option("--no-extensions", help="run no file of the folder extensions"),
    ] = False,
) -> None:
    from ur5lib.workspace.extensions import LEFT_OUT, NAMED, USE_VARIABLE

    os.environ[USE_VARIABLE] = LEFT_OUT if no_extensions else NAMED
    context.call_on_close(lambda: os.environ.pop(USE_VARIABLE, None))


@app.command(rich_help_panel="Start")
def new(
    folder: Annotated[Path, typer.Argument(help="workspace to make; . is the folder you are in")],
) -> None:
    """Make a workspace: a folder for your recordings, in which `snakemake` builds their report."""
    from ur5lib.workspace.new import new_workspace

    typer.echo(new_workspace(folder))


@app.command(rich_help_panel="Start")
def fetch(
    dataset: Annotated[
        str | None, typer.Argument(help="name of a published data set; default: list them")
    ] = None,
    source: Annotated[
        Path | None, typer.Option("--from", help="copy from this folder instead of the network")
    ] = None,
    target: Annotated[
        Path | None, typer.Option("--to", help="folder to write to; default: raw/<dataset>")
    ] = None,
) -> None:
    """Download a published data set into raw/ and verify every file, or list them all."""
    from ur5lib.datasets.catalogue import catalogue, listing
    from ur5lib.datasets.fetching import fetch as fetch_dataset
    from ur5lib.workspace.new import copy_study

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # removes temporary files
    if dataset is None:
        print_lines(listing())
        return
    typer.echo(fetch_dataset(dataset, target, source))
    study = catalogue()[dataset].study
    if study and target is None:
        typer.echo(f"next: ur5 run {copy_study(study)}")


@app.command(rich_help_panel="Start")
def run(
    study_or_recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="STUDY | RECORDINGS",
            help=f"{STUDY_HELP}; or recordings, of which a study is written first. Options of "
            "Snakemake follow after --",
        ),
    ],
    robot: Annotated[str | None, typer.Option(help="name of the arm of the recordings")] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="study file of the recordings; default: <their folder>.yaml"
        ),
    ] = None,
    open_report: Annotated[bool, typer.Option("--open", help="show the report at the end")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="print all of Snakemake's lines")
    ] = False,
) -> None:
    """Build the report of a study, or of recordings: what is new or has changed is computed."""
    _use_one_thread()
    from ur5lib.commands.run import build
    from ur5lib.importing.written import study_of

    named = [*takewhile(lambda word: not word.startswith("-"), study_or_recordings)]
    options = study_or_recordings[len(named) :]
    study = study_of(named, robot, output)
    built = build(study, results_folder(str(study)), options, verbose)
    if built.is_file():  # not after a dry run
        _show(built, open_report)


@app.command(rich_help_panel="Start")
def report(
    results: Results,
    open_report: Annotated[bool, typer.Option("--open", help="show it in the browser")] = False,
) -> None:
    """Print the file of a study's report, or show it."""
    file = results / "report.html"
    if not file.is_file():
        raise InputError(f"{file} does not exist; build it: ur5 run {results.name}")
    _show(file, open_report)


def _show(report: Path, open_report: bool) -> None:
    typer.echo(f"report: {report}")
    if open_report:
        typer.launch(str(report))


@app.command(rich_help_panel="Start")
def status(study: StudyFile) -> None:
    """Print whether a study is being built, what its report lacks, and what a run would compute."""
    from ur5lib.commands.run import status as lines

    print_lines(lines(study, results_folder(str(study))))


@app.command(rich_help_panel="Start")
def check(
    study: StudyFile,
    recordings: Annotated[
        list[str] | None, typer.Argument(help="some of its recordings, to see them in detail")
    ] = None,
) -> None:
    """Check every recording of a study: read it, repair it, and print the findings."""
    _use_one_thread()
    from ur5lib.commands.check import print_findings

    if print_findings(study, recordings or []):
        raise SystemExit(1)
    typer.echo(f"next: ur5 run {shlex.quote(str(study))}")


@app.command(name="import", rich_help_panel="Start")
def import_(
    files: Annotated[list[Path], typer.Argument(help="recordings of any known format")],
    robot: Annotated[str | None, typer.Option(help="name of the arm")] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            help="channels of a table's columns in order, as time,actual_q,-,actual_current; of "
            "arrays, as actual_q=run/positions"
        ),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="rows per second [Hz] of files without a clock", min=1)
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(help="unit of a channel, as actual_current=mA")
    ] = None,
    write: Annotated[
        Path | None, typer.Option(help="study file to write; default: print the entries")
    ] = None,
    add: Annotated[Path | None, typer.Option(help="study to append the entries to")] = None,
) -> None:
    """Write the study entry of recordings, with what is proven, assumed, or to be checked."""
    typer.echo(f"files to read: {len(files)}", err=True)  # before packages that load for seconds
    _use_one_thread()
    from ur5lib.importing.written import (
        imported_files,
        print_imported,
        user_statement,
        write_imported,
    )

    imported = imported_files(files, user_statement(robot, columns, rate, unit or []))
    if study := write or add:
        last_line = f"{study} written; next: ur5 check {study}"
        write_imported(imported, study, last_line, append=write is None)
    else:
        given = [word for word in sys.argv[1:] if word != "import"]
        print_imported(imported, f"ur5 import {shlex.join(given)} --write mine.yaml")


def _use_one_thread() -> None:
    """Let NumPy, which is loaded next, use one core: threads take longer for small matrices."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")


@app.command(rich_help_panel="Results")
def compare(
    before: Results,
    after: Results,
    fail_on: Annotated[
        str, typer.Option(help="topics whose change gives exit status 1, e.g. force,currents")
    ] = "",
    junit: Annotated[Path | None, typer.Option(help="JUnit XML file to write")] = None,
) -> None:
    """List what changed between two results by more than its error."""
    from ur5lib.commands.compare import TOPICS, lines, write_junit
    from ur5lib.commands.compare import compare as compare_results

    topics = [topic for topic in fail_on.split(",") if topic]
    for topic in topics:
        if topic not in TOPICS:
            raise unknown("topic", topic, TOPICS)
    comparisons = compare_results(before, after)
    print_lines(lines(comparisons))
    if junit:
        write_junit(comparisons, junit)
    if any(each.changed and each.topic in topics for each in comparisons):
        raise SystemExit(1)


@app.command(rich_help_panel="Results")
def audit(study: StudyFile) -> None:
    """Print the faults of the wrist sensors in a study's recordings, and the remedies."""
    from ur5lib.commands.answers import audit_answers

    print_lines(audit_answers(study))


@app.command(rich_help_panel="Results")
def payload(study: StudyFile) -> None:
    """Print the payload of each recording by motor currents and by wrist sensor."""
    from ur5lib.commands.answers import payload_answers

    print_lines(payload_answers(study))


@app.command(rich_help_panel="Arm")
def export(
    robot: ArmName,
    model: Annotated[
        str | None,
        typer.Option(help="name of one of its link models; default: the chosen or identified one"),
    ] = None,
    to: Annotated[
        str,
        typer.Option(
            help="output format: urdf, mjcf, sdf, isaac, json, sensor, live, and of the estimator "
            "that reads this: live.py, live.hpp, live.schema.json"
        ),
    ] = "urdf",
    results: Annotated[
        Path | None,
        typer.Option(parser=results_folder, help=f"a study that identified it: {ADDRESS_HELP}"),
    ] = None,
    as_in: Annotated[
        str, typer.Option(help="a recording of that study: with its payload, mounting and TCP")
    ] = "",
    ros_names: Annotated[
        bool, typer.Option("--ros-names", help="call the joints of a UR as ROS does")
    ] = False,
) -> None:
    """Print an arm for other programs: as a model, all known parameters (json), the bias and tool
    of its force sensor (sensor), or what tells the force while it runs (live)."""
    from ur5lib.commands.exported import exported

    typer.echo(exported(robot, model, to, results, as_in, ros_names))


@app.command(rich_help_panel="Arm")
def describe(
    file: Annotated[Path, typer.Argument(help="URDF of a serial arm of 2 to 8 revolute joints")],
    base: Annotated[str | None, typer.Option(help="link that stands; default: the root")] = None,
    tip: Annotated[
        str | None, typer.Option(help="link of the flange; default: the last that turns")
    ] = None,
    name: Annotated[str | None, typer.Option(help="name of the arm; default: the file's")] = None,
    physical: Annotated[
        bool,
        typer.Option(
            "--physical",
            help="where no body has the inertia of a link, add a model with the nearest possible",
        ),
    ] = False,
) -> None:
    """Describe an arm by its URDF: writes robots/<name>.yaml, for `robot: <name>` in a study."""
    from ur5lib.commands.described import describe_urdf

    print_lines(describe_urdf(file, base, tip, name, physical))


@app.command(rich_help_panel="Results")
def convert(
    results: Results,
    recordings: Annotated[
        list[str] | None, typer.Argument(help="some of its recordings; default: all")
    ] = None,
    to: Annotated[str, typer.Option(help="output format: mat, csv, mcap")] = "mat",
    into: Annotated[
        Path | None, typer.Option(help="folder to write to; default: results/<study>/exported")
    ] = None,
) -> None:
    """Write a study's signals, motion, currents and forces, with bands, for MATLAB or Foxglove."""
    from ur5lib.commands.convert import write_recordings

    print_lines(write_recordings(results, recordings or [], to, into))


@app.command(rich_help_panel="Results")
def figure(
    results: Results,
    figure: Annotated[str, typer.Argument(help="one in its folder figures, as pushed/torques")],
    width: Annotated[str, typer.Option(help="width in millimetres")] = "88mm",
    font_size: Annotated[float, typer.Option(help="size of all letters [points]")] = 8,
    format: Annotated[str, typer.Option(help="file format: pdf, svg, png")] = "pdf",
) -> None:
    """Draw a figure of a study as a paper needs it, and print its file."""
    from ur5lib.study.paper_figure import paper_figure

    typer.echo(paper_figure(results, figure, width, font_size, format))


@app.command(rich_help_panel="Results")
def replay(
    file: Annotated[Path, typer.Argument(help="model of the arm: MJCF or URDF")],
    results: Results,
    recording: Annotated[str, typer.Argument(help="one of its recordings")],
) -> None:
    """Replay a model along a recording in MuJoCo: errors of torque, and of angles in a loop."""
    from ur5lib.commands.replay import replayed

    print_lines(replayed(file, results, recording))


@app.command(rich_help_panel="Project")
def schema() -> None:
    """Print the JSON schema of a study (workflow/study.schema.json)."""
    from ur5lib.study.model import schema_text

    typer.echo(schema_text(), nl=False)


@app.command(rich_help_panel="Project")
def settings() -> None:
    """Print every setting of a study with its default (docs/settings.md)."""
    from ur5lib.study.schema import settings_text

    typer.echo(settings_text(), nl=False)


for own in commands_beside():
    app.command(own.name, rich_help_panel=own.panel)(own.run)
for command in app.registered_commands:
    command.short_help = getattr(command.callback, "__doc__", None)  # of `help`, click shows a part


def main() -> None:
    """Run the command; an error that a user can correct is one sentence, with exit status 1."""
    try:
        app()
    except InputError as error:
        typer.echo(f"ur5: {error}", err=True)
        raise SystemExit(1) from error
    except OSError as error:
        if error.filename is None:
            raise
        typer.echo(
            f"ur5: {printable(str(error.filename))} cannot be used ({error.strerror}); check its "
            "name and the permissions",
            err=True,
        )
        raise SystemExit(1) from error
