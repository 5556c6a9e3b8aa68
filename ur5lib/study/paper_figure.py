"""A figure of a finished study as a paper needs it, drawn again by its own step."""

import re
import subprocess
import sys
from pathlib import Path

from ur5lib.errors import InputError, perhaps, some, unknown
from ur5lib.study.reading import read_plain
from ur5lib.tables import intact
from ur5lib.workspace.places import SNAKEFILE, WORKFLOW

PROFILE = WORKFLOW / "profiles" / "default"
FORMATS = ("pdf", "svg", "png")
WIDTHS, FONT_SIZES = (40, 400), (4, 20)  # mm, points


def paper_figure(
    results: Path, figure: str, width: str = "88mm", font_size: float = 8, format: str = "pdf"
) -> Path:
    """Return the file of a figure, results/<study>/paper/<figure>_<width>_<font size>pt.<format>.

    Snakemake draws it, by the step of the report, of the results as they are. figure: as in
    results/<study>/figures, `pushed/forces_estimated` or `calibration`; width: in mm, "88mm";
    font_size: of all letters [points]; format: of `FORMATS`. Raises InputError for what it does not
    know, and where the figure cannot be drawn.
    """
    if format not in FORMATS:
        raise unknown("format", format, FORMATS)
    expect_figure(results, figure)
    sizes = f"{millimetres(width):g}mm_{_within(font_size, FONT_SIZES, '--font-size'):g}pt"
    file, place = f"paper/{figure}_{sizes}.{format}", results.resolve()
    study = str(place / "configuration.yaml")
    command = [sys.executable, "-P", "-m", "snakemake", "--snakefile", str(SNAKEFILE)]
    command += ["--workflow-profile", str(PROFILE)]  # not one that lies beside the results
    command += ["--configfile", study, "--cores", "1", "--quiet", "rules"]
    command += [
        "--allowed-rules",
        f"paper_{Path(figure).name}",
        "--",
        f"results/{place.name}/{file}",
    ]
    done = subprocess.run(command, cwd=place.parents[1], text=True, capture_output=True)
    if done.returncode:
        raise InputError(f"{figure} cannot be drawn:\n{(done.stderr or done.stdout).strip()}")
    return results / file


def expect_figure(results: Path, figure: str) -> None:
    """Raise InputError where a study has no such figure, or no longer the name of its folder."""
    drawn = sorted(
        str(path.relative_to(results / "figures").with_suffix(""))
        for path in results.glob("figures/**/*.svg")
    )
    configuration = results / "configuration.yaml"
    if not drawn or not configuration.is_file():
        raise InputError(
            f"{results} holds no figures of a finished study; `ur5 run` it to its end, and "
            "name the folder results/<study>"
        )
    if figure not in drawn:
        of_recordings = [name for name in drawn if Path(name).name == figure]
        near = f" (it has {some(of_recordings)})" if of_recordings else perhaps(figure, drawn)
        raise InputError(
            f"{results} has no figure {figure!r}{near}; `ur5 run <study> -- figures` draws those "
            f"of all recordings; see {results}/figures"
        )
    with intact(configuration):
        name = read_plain(configuration)["study"]
    if results.resolve().parts[-2:] != ("results", name):
        raise InputError(f"{results} was results/{name} when it was made; move it back")


def millimetres(width: str) -> float:
    """Return a width, as 88mm, in millimetres. Raises InputError for others."""
    stated = re.fullmatch(r"(\d+(?:\.\d+)?)mm", width)
    if not stated:
        raise InputError(f"--width {width}: state it in millimetres, as 88mm")
    return _within(float(stated[1]), WIDTHS, "--width")


def _within(value: float, ends: tuple[float, float], option: str) -> float:
    """Return a value. Raises InputError outside its ends."""
    if not ends[0] <= value <= ends[1]:
        raise InputError(f"{option} {value:g}: state {ends[0]} to {ends[1]}")
    return value
