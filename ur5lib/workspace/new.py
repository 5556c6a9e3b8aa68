"""`ur5 new`: a workspace, a folder for recordings, in which `ur5 run` builds their report."""

from pathlib import Path
from shlex import quote

from ur5lib.errors import InputError
from ur5lib.strict import read_yaml
from ur5lib.tables import made, write_text
from ur5lib.workspace.places import WORKFLOW

TEMPLATES = Path(__file__).parent / "templates"
SCHEMA = "workflow/study.schema.json"  # named in the first line of a study


def new_workspace(folder: Path) -> str:
    """Make a workspace: Snakefile, studies, README.md, raw/, profiles/. Return a sentence on what
    to do next.

    Files that are there already stay as they are. Raises InputError where the folder has a
    Snakefile, or cannot be written.
    """
    if (folder / "Snakefile").exists():
        raise InputError(f"{folder} has a Snakefile: `ur5 run` in it, or name another folder")
    made(made(folder) / "raw")
    for name, text in _contents().items():  # the Snakefile last: with it, the folder is complete
        if not (folder / name).exists():
            write_text(text, folder / name)
    enter = "" if folder.resolve() == Path.cwd() else f"cd {quote(str(folder))} && "
    return f"{folder} is ready; next: {enter}ur5 run config.yaml --open"


def copy_study(name: str) -> Path:
    """Copy a study of the package, and its printed numbers, to the same place in the working
    folder; return its path there.
    """
    reference = read_yaml(WORKFLOW / name).get("reference")
    for file in filter(None, [name, reference, SCHEMA]):
        if not Path(file).exists():
            write_text((WORKFLOW / file).read_text(encoding="utf-8"), file)
    return Path(name)


def _contents() -> dict[str, str]:
    """Return the content of each file of a new workspace by its name."""
    schema, config = (WORKFLOW / "config.yaml").read_text(encoding="utf-8").split("\n", 1)
    example = (TEMPLATES / "config.yaml").read_text(encoding="utf-8")
    copied = {_relative(path): path for path in WORKFLOW.glob("profiles/*/config.yaml")}
    copied |= {_relative(path): path for path in WORKFLOW.glob("workflow/studies/*.yaml")}
    copied |= {SCHEMA: WORKFLOW / SCHEMA}
    copied |= {path.name: path for path in (TEMPLATES / "README.md", TEMPLATES / "Snakefile")}
    texts = {name: path.read_text(encoding="utf-8") for name, path in copied.items()}
    return {"config.yaml": f"{schema}\n{example}{config}"} | texts


def _relative(path: Path) -> str:
    """Return the path of a file relative to the package's workflow, which is also its path in a
    workspace.
    """
    return str(path.relative_to(WORKFLOW))
