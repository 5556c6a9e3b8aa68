"""The command-line interface `ur5`."""

import errno
import os
import re
import shlex
import signal
import sys
from inspect import cleandoc
from itertools import chain, takewhile
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer

from ur5lib import __version__
from ur5lib.commands.arguments import (
    ADDRESS_HELP,
    STUDY_HELP,
    AsJson,
    StudyFile,
    as_text,
    print_lines,
)
from ur5lib.commands.interrupts import signals_interrupt
from ur5lib.errors import InputError, fault_of_ours, printable, unknown
from ur5lib.study.address import results_folder, study_file
from ur5lib.workspace.beside import commands_beside
from ur5lib.workspace.extensions import LEFT_OUT, NAMED, USE_VARIABLE
from ur5lib.workspace.origin import commit, foreign, lock
from ur5lib.workspace.topics import modules_of_topics

PANELS = "Start", "Lab", "Results", "Arm", "Others"
ArmName = Annotated[str, typer.Option(help="name of an arm in ur5lib/robots, e.g. ur5")]


EXPORTS = [*modules_of_topics("exports").values()]
EXPORTED = ["urdf", "mjcf", "sdf", "isaac", "json", "sensor"]
EXPORTED += [name for topic in EXPORTS for name in topic.FORMATS]
EXPORTED += [name for topic in EXPORTS for name in vars(topic).get("FOLDERS", ())]
OTHERWISE = {  # former options of commands, with the present ones
    "import": {"--write": "--output"},
    "excite": {"--write": "--output"},
    "convert": {"--to": "--format"},
    "export": {"--to": "--format"},
    "fetch": {"--to": "--output"},
    "compare": {"--junit": "--output"},
}
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}  # a disk, or what the output goes to
NO_MEMORY = "failed to map segment"  # of a package's library
KEPT = {  # printed after Ctrl-C; files are renamed when complete, so that none is half written
    "run": "the steps that are done are kept, and the same command goes on",
    "convert": "the copies that are complete are kept, and --resume makes the others",
    "fetch": "the files that are complete are kept, and the same command fetches the others",
}


class Named(typer.core.TyperArgument):
    """A positional argument of a command, which `--help` shows only by its name, with dots if it
    may be repeated.
    """

    def display_type_rich(self, ctx: Any) -> None:
        """Return None, so that help shows no type next to the name."""

    def get_usage_pieces(self, _: Any) -> list[str]:
        """Return the name, in brackets if it is optional."""
        return [str(self.metavar) if self.required else f"[{self.metavar}]"]


class Panels(typer.core.TyperGroup):
    """Commands, listed by purpose on one screen."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        for one in chain.from_iterable(command.params for command in self.commands.values()):
            if isinstance(one, typer.core.TyperArgument):
                one.__class__ = Named
                one.metavar = (one.metavar or one.name.upper()) + "..." * (one.nargs != 1)

    def format_commands(self, _: Any, formatter: Any) -> None:
        """Write the commands of each of PANELS in the order of definition."""
        panels: dict[str, list[tuple[str, str]]] = {panel: [] for panel in PANELS}
        for name, command in self.commands.items():
            row = name, (command.short_help or "").partition("\n\n")[0]
            panels[vars(command)["rich_help_panel"]].append(row)
        width = max(map(len, self.commands))
        for panel, rows in filter(itemgetter(1), panels.items()):
            formatter.write_heading(panel)
            formatter.indent()
            formatter.write_dl([(name.ljust(width), text) for name, text in rows])
            formatter.dedent()

    def resolve_command(self, context: Any, words: list[str]) -> Any:
        """Return the command that a user named, and its arguments; an option under its former name
        prints the present one and exits.
        """
        name, command, rest = super().resolve_command(context, words)
        known = OTHERWISE.get(name or "", {})
        own = [*takewhile(lambda word: word != "--", rest)]
        if old := next((word for word in own if word.partition("=")[0] in known), None):
            option, sign, value = old.partition("=")
            now = [f"{known[option]}{sign}{value}" if word == old else word for word in rest]
            line = printable(shlex.join(["ur5", str(name), *now]))
            typer.echo(f"ur5: {option} is called {known[option]} now: {line}", err=True)
            raise SystemExit(2)
        return name, command, rest

    def invoke(self, context: Any) -> Any:
        """Run a command; a wrong call prints an example, with exit status 2.

        A call without a study lists the studies, and Ctrl-C prints what is kept. Raises InputError
        for an invalid choice of an option.
        """
        try:
            return super().invoke(context)
        except KeyboardInterrupt as stop:
            kept = KEPT.get(str(context.invoked_subcommand), "no file is left incomplete")
            typer.echo(f"ur5: stopped; {kept}", err=True)
            raise SystemExit(128 + signal.SIGINT) from stop
        except Exception as error:
            if not hasattr(error, "format_message"):
                raise
            message = str(getattr(error, "message", ""))
            if "is not one of" not in message:
                said = error.format_message().rstrip(".")
                command = self.commands.get(context.invoked_subcommand or "")
                typer.echo(f"ur5: {said}; {_right_call(command, said)}", err=True)
                if said.startswith("Missing argument 'STUDY"):
                    _print_studies()
                raise SystemExit(2) from error
            wrong, *choices = re.findall(r"'([^']*)'", message)
            option = getattr(getattr(error, "param", None), "name", "choice")
            raise unknown(str(option), wrong, choices) from error


def _right_call(command: Any, said: str) -> str:
    """Return the hint after a wrong call: the example of the command, or where commands and
    Snakemake's options are listed.
    """
    if command is None:
        return "`ur5 -h` lists the commands"
    if command.name == "run" and said.startswith("No such option"):
        return "Snakemake's options follow after --, as in: ur5 run mine -- --cores 4"
    return f"as in: {command.help.partition('Example: ')[2].strip()}"


def _print_studies() -> None:
    from ur5lib.commands.listed import studies_here

    print_lines(studies_here())


app = typer.Typer(
    cls=Panels,
    help="Dynamics, friction and contact force of robot arms, from recordings.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,  # markup would swallow units such as [s]
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"ur5lib {__version__}, commit {commit()}, lock {lock()}")
        if warning := foreign():
            typer.echo(warning, err=True)
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
    os.environ[USE_VARIABLE] = LEFT_OUT if no_extensions else NAMED
    context.call_on_close(lambda: os.environ.pop(USE_VARIABLE, None))


@app.command(rich_help_panel="Start")
def new(
    folder: Annotated[Path, typer.Argument(help="workspace to make; . is the folder you are in")],
) -> None:
    """Make a workspace, a folder for your recordings.

    In it, `ur5 run` builds their report. Example: ur5 new mylab
    """
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
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="folder to write to; default: raw/<dataset>"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Download a published data set into raw/, or list them all.

    Every file with a known checksum is verified. Example: ur5 fetch ur10-bag
    """
    from ur5lib.datasets.catalogue import catalogue, listing
    from ur5lib.datasets.fetching import fetch as fetch_dataset
    from ur5lib.workspace.new import copy_study

    if dataset is None:
        print_lines(
            [as_text({n: one.model_dump() for n, one in catalogue().items()})]
            if as_json
            else listing()
        )
        return
    with signals_interrupt():  # removes temporary files
        typer.echo(fetch_dataset(dataset, output, source))
    study = catalogue()[dataset].study
    if study and output is None:
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
    quiet: Annotated[
        bool, typer.Option("--quiet", help="print no progress, only what went wrong")
    ] = False,
) -> None:
    """Build the report of a study, or of recordings.

    What is new or has changed is computed. Example: ur5 run raw/mine/*.csv --robot ur5e --open
    """
    _use_one_thread()
    from ur5lib.commands.run import build
    from ur5lib.importing.written import study_of

    named = [*takewhile(lambda word: not word.startswith("-"), study_or_recordings)]
    options = study_or_recordings[len(named) :]
    study = study_of(named, robot, output)
    built = build(study, results_folder(str(study)), options, verbose, quiet)
    if built:
        _show(built, open_report)


@app.command(rich_help_panel="Start")
def report(
    studies: Annotated[
        list[Path],
        typer.Argument(parser=results_folder, metavar="STUDY", help=f"{STUDY_HELP}, or several"),
    ],
    open_report: Annotated[bool, typer.Option("--open", help="show it in the browser")] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="page of several; default: results/studies.html"),
    ] = None,
) -> None:
    """Print the states of a study's cards and the file of its report, or show it.

    Of several studies, as results/*, write one page: their verdicts by study, arm and date, and
    what changed. Example: ur5 report mine --open
    """
    if len(studies) > 1:
        from ur5lib.commands.several import write_several

        _show(write_several(studies, output or studies[0].parent / "studies.html"), open_report)
        return
    from ur5lib.commands.verdicts import card_states, lines

    (results,) = studies
    file = results / "report.html"
    if not file.is_file():
        raise InputError(f"{file} does not exist; build it: ur5 run {results.name}")
    print_lines(lines(card_states(results), results.name))
    _show(file, open_report)


def _show(report: Path, open_report: bool) -> None:
    import webbrowser

    shown = not open_report or webbrowser.open(report.resolve().as_uri())
    typer.echo(f"report: {report}" if shown else f"no browser is found; report: {report}")


@app.command(name="list", rich_help_panel="Start")
def list_() -> None:
    """List the studies of this folder, and which are built.

    Each by its name, its file and its report. Example: ur5 list
    """
    _print_studies()


@app.command(rich_help_panel="Start")
def status(study: StudyFile, as_json: AsJson = False) -> None:
    """Print whether a study is built, the states of its cards, what a run would compute, and why.

    Example: ur5 status mine
    """
    from ur5lib.commands.run import state

    found = state(study, results_folder(str(study)))
    print_lines([as_text(found)] if as_json else found.lines())


@app.command(rich_help_panel="Start")
def check(
    study: StudyFile,
    recordings: Annotated[
        list[str] | None, typer.Argument(help="some of its recordings, to see them in detail")
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="list what could not be checked or is not used, too")
    ] = False,
    as_json: AsJson = False,
    contract: Annotated[
        Path | None, typer.Option(help="file with what every recording must have")
    ] = None,
    new_contract: Annotated[
        Path | None, typer.Option("--write-contract", help="write such a file from good recordings")
    ] = None,
) -> None:
    """Check every recording of a study, and print the findings.

    Each is read and repaired. Exit status 1: a stop sign or an error. Example: ur5 check mine
    """
    _use_one_thread()
    from ur5lib.commands.check import Form, print_findings
    from ur5lib.commands.contract import read_contract, write_contract
    from ur5lib.study.reading import read_study

    wanted = read_contract(contract) if contract else None
    if print_findings(study, recordings or [], Form(everything, as_json), wanted):
        raise SystemExit(1)
    if new_contract:
        write_contract(read_study(study), recordings or [], new_contract)
        typer.echo(f"{new_contract} written", err=as_json)
    if as_json:
        return
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
        list[str] | None,
        typer.Option(
            metavar="CHANNEL=UNIT",
            help="unit of a channel, as actual_current=mA, or the SI value of one unit, "
            "of each joint if they differ: actual_q=1e-5,2e-5,…",
        ),
    ] = None,
    joints: Annotated[
        str,
        typer.Option(
            help="names of the arm's joints, in its order, with commas between; or the joint of "
            "each column, as 3,2,1,4,5,6"
        ),
    ] = "",
    prefix: Annotated[
        str, typer.Option(help="what the names of the arm's joints begin with, as left_")
    ] = "",
    sensor: Annotated[
        Path | None,
        typer.Option("--with", help="file of the force sensor, on its own clock"),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="list the evidence for each column, too")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="study file to write; default: print the entries"),
    ] = None,
    add: Annotated[
        Path | None,
        typer.Option(
            parser=study_file,
            metavar="STUDY",
            help=f"append the entries to a study: {ADDRESS_HELP}",
        ),
    ] = None,
) -> None:
    """Write the study entry of recordings, with what is proven.

    Example: ur5 import raw/mine/*.csv --robot ur5e -o mine.yaml
    """
    typer.echo(f"files to read: {len(files)}", err=True)  # before imports that take seconds
    _use_one_thread()
    from ur5lib.importing.files import expect_new
    from ur5lib.importing.written import (
        imported_files,
        print_imported,
        user_statement,
        write_imported,
    )

    if output is not None:
        expect_new(output)  # before the files are read
    imported = imported_files(
        files, user_statement(robot, columns, rate, unit or [], joints, prefix, sensor)
    )
    if study := output or add:
        last_line = f"{study} written; next: ur5 check {study}"
        write_imported(imported, study, last_line, append=output is None, everything=everything)
    else:
        given = [word for word in sys.argv[1:] if word != "import"]
        command = f"ur5 import {shlex.join(given)} --output mine.yaml"
        print_imported(imported, command, everything)


def _use_one_thread() -> None:
    """Let NumPy, which is loaded next, use one core: threads take longer for small matrices."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")


@app.command(rich_help_panel="Results")
def payload(study: StudyFile, as_json: AsJson = False) -> None:
    """Print each recording's payload by currents and by wrist sensor.

    Example: ur5 payload mine
    """
    from ur5lib.commands.answers import payload_answers, payload_numbers

    print_lines([as_text(payload_numbers(study))] if as_json else payload_answers(study))


@app.command(rich_help_panel="Arm")
def export(
    robot: ArmName,
    model: Annotated[
        str | None,
        typer.Option(help="name of one of its link models; default: the chosen or identified one"),
    ] = None,
    format: Annotated[
        str,
        typer.Option(
            metavar=f"[{'|'.join(EXPORTED)}]",
            autocompletion=lambda: EXPORTED,
            help="; ".join(["what it is for", *(topic.HELP for topic in EXPORTS)]),
        ),
    ] = "urdf",
    results: Annotated[
        Path | None,
        typer.Option(
            parser=results_folder,
            metavar="STUDY",
            help=f"a study that identified it: {ADDRESS_HELP}",
        ),
    ] = None,
    as_in: Annotated[
        str, typer.Option(help="a recording of that study: with its payload, mounting and TCP")
    ] = "",
    ros_names: Annotated[
        bool, typer.Option("--ros-names", help="call the joints of a UR as ROS does")
    ] = False,
    accept: Annotated[
        str,
        typer.Option(
            help="why to export what the study's verdicts say not to use; the file has the reason"
        ),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="file, or folder, to write; default: print it"),
    ] = None,
) -> None:
    """Print an arm for other programs, as a model or as numbers.

    json: all known parameters; sensor: bias and tool of its force sensor.
    Example: ur5 export --robot ur5e --format mjcf -o ur5e.xml
    """
    from ur5lib.commands.exported import FOLDERS, exported, write_folder

    if format in FOLDERS and output is not None:
        write_folder(format, robot, results, as_in, accept, output)
        typer.echo(f"{output} written")
        return
    asked = robot, model, format, results, as_in, ros_names, accept
    if output is None:
        typer.echo(exported(*asked))
        return
    from ur5lib.study.turn import reserved
    from ur5lib.tables import write_text

    with reserved(output):
        write_text(exported(*asked) + "\n", output)
    typer.echo(f"{output} written")


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
    """Describe an arm by its URDF, for `robot: <name>` in a study.

    Writes robots/<name>.yaml. Example: ur5 describe arm.urdf --tip flange --name my-arm
    """
    from ur5lib.commands.described import describe_urdf

    print_lines(describe_urdf(file, base, tip, name, physical))


@app.command(rich_help_panel="Results")
def convert(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY", help=f"{STUDY_HELP}; with --into, also the file of a model"
        ),
    ],
    recordings: Annotated[
        list[str] | None,
        typer.Argument(help="some of its recordings; default: all; with --into, files or folders"),
    ] = None,
    format: Annotated[
        Literal["mat", "csv", "mcap"], typer.Option(help="for MATLAB, any program, Foxglove")
    ] = "mat",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="folder to write to; default: results/<study>/exported"
        ),
    ] = None,
    into: Annotated[
        Path | None,
        typer.Option(help="folder for copies of the files, in their own format, with the force"),
    ] = None,
    robot: Annotated[
        str | None, typer.Option(help="name of the arm, if files are named without a study")
    ] = None,
    fit: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN", help="files without contact to fit to, as 'free*'; default: no fit"
        ),
    ] = None,
    accept: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND=REASON", help="why a stop sign is overruled; the copies have the reason"
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="leave copies as they are that are there")
    ] = False,
) -> None:
    """Write signals, motion and forces for MATLAB or Foxglove.

    Currents and bands, too; with --into, copies of your files with the force in each row, as by
    ur5 convert mine raw/episodes --into forces. Example: ur5 convert mine pushed --format mcap
    """
    if into is None:
        from ur5lib.commands.convert import write_recordings

        if robot or fit or accept or resume:
            raise InputError("--robot, --fit, --accept and --resume belong to --into <folder>")
        print_lines(write_recordings(results_folder(study), recordings or [], format, output))
        return
    _use_one_thread()
    from ur5lib.commands.into import Readers, copies_into
    from ur5lib.importing.episodes import Episodes
    from ur5lib.importing.in_memory import read, read_arm

    with signals_interrupt():
        readers = Readers(read, read_arm, Episodes)
        named = [study, *(recordings or [])]
        asked = named, robot, fit or [], accept or []
        print_lines(copies_into(into, *asked, resume, readers))


@app.command(rich_help_panel="Others")
def schema(
    of: Annotated[
        Literal["study", "contract"], typer.Argument(metavar="study|contract", help="kind of file")
    ] = "study",
) -> None:
    """Print the JSON schema of a study, or of a contract for recordings.

    It is workflow/study.schema.json. Example: ur5 schema > study.schema.json
    """
    from ur5lib.commands.contract import contract_schema
    from ur5lib.study.model import schema_text

    typer.echo(schema_text() if of == "study" else contract_schema(), nl=False)


@app.command(rich_help_panel="Others")
def settings() -> None:
    """Print every setting of a study with its default.

    It is docs/settings.md. Example: ur5 settings > settings.md
    """
    from ur5lib.study.schema import settings_text

    typer.echo(settings_text(), nl=False)


for topic, module in modules_of_topics("command").items():  # a topic's own, which has its name
    app.command(rich_help_panel="Results")(getattr(module, topic))

for own in commands_beside():
    app.command(own.name, rich_help_panel=own.panel)(own.run)
for command in app.registered_commands:
    command.short_help = cleandoc(getattr(command.callback, "__doc__", None) or "")


def main() -> None:
    """Run the command; an error is one sentence, with exit status 1."""
    try:
        _run()
    except Exception as error:
        _end(_sentence_of(error), error)


def _sentence_of(error: Exception) -> str:
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError) and error.filename is not None:
        name = printable(str(error.filename))
        return f"{name} cannot be used ({error.strerror}); check its name and the permissions"
    if isinstance(error, OSError) and error.errno in FULL:
        return f"no room to write to ({error.strerror}); free some, or send the output elsewhere"
    if _is_of_memory(error):
        return "the memory is full; end other programs, or use fewer or shorter recordings"
    return str(fault_of_ours(error))


def _run() -> None:
    """Run the command, and write its output to the end. Raises InputError without an output."""
    if sys.stdout is None:  # the first opened file would be taken for it
        raise InputError("the output is closed; send it to a file, or to /dev/null")
    try:
        app()
    finally:
        sys.stdout.flush()


def _is_of_memory(error: BaseException | None) -> bool:
    """Return whether an error, or what caused it, is a lack of memory, also that of a package that
    cannot be loaded.
    """
    if error is None or isinstance(error, MemoryError):
        return error is not None
    return NO_MEMORY in str(error) or _is_of_memory(error.__cause__ or error.__context__)


def _end(sentence: str, error: BaseException) -> NoReturn:
    try:
        sys.stdout.flush()
    except (AttributeError, OSError):  # else the rest is tried again at the exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    typer.echo(f"ur5: {sentence}", err=True)
    raise SystemExit(1) from error
