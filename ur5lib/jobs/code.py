"""The checksum of a step's code, since Snakemake does not follow the imports of a step.

`python -m ur5lib.jobs.code ur5lib/force/gate.py` prints the steps that use a file; `snakemake -n
--quiet host` adds what the results of these steps feed.
"""

import sys
from collections.abc import Collection, Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path

from ur5lib.jobs.syntax import syntax
from ur5lib.workspace.extensions import source_files
from ur5lib.workspace.places import PACKAGE

LOOPS = {  # modules that a module imports by a loop over folders
    "report/page/handed.py": ("report/views/*.py", "topics/*/report.py"),
    "report/topics.py": ("topics/*/found.py",),
}


def checksum_of_step(step: str, files: Collection[Path] = ()) -> str:
    """Return a checksum of a step's module, of all modules that it uses, and of `files`.

    Of Python's files, what can change a result (`ur5lib.jobs.syntax`); of others, all bytes.

    files: further files of the library that the step reads. The checksum does not depend on the
    place of installation. A user's extensions count as code of the steps that use the modules that
    load them.
    """
    modules = modules_of_step(step)
    every = [*modules, *sorted({*files}), *source_files({*modules})]
    return sha256(b"".join(map(_counted, every))).hexdigest()[:16]


def module_of(step: str) -> Path:
    """Return the file of a step's module, in the folder of its topic or in `steps`."""
    of_topic = PACKAGE.glob(f"topics/*/{step}.py")
    return next(of_topic, PACKAGE / "steps" / f"{step}.py")


def all_steps() -> list[str]:
    """Return the names of the steps: modules that contain a function with the module's name."""
    modules = *PACKAGE.glob("steps/*.py"), *PACKAGE.glob("topics/*/*.py")
    return sorted(own.stem for own in modules if f"\ndef {own.stem}(" in own.read_text())


def modules_of_step(step: str) -> list[Path]:
    """Return the files of a step's module and of all modules that it uses, directly or not."""
    modules, unseen = set[Path](), {module_of(step)}
    while unseen:
        modules |= unseen
        unseen = {used for module in unseen for used in imported_modules(module)} - modules
    return sorted(modules)


@cache
def _counted(path: Path) -> bytes:
    """Return what of a file counts."""
    return syntax(path).checksum.encode() if path.suffix == ".py" else path.read_bytes()


@cache
def imported_modules(path: Path) -> set[Path]:
    """Return the files of ur5lib modules that a Python file imports, without importing them.

    The report imports its views and the modules of topics by loops over folders.
    """
    names = [name for name in syntax(path).imports if name.startswith(PACKAGE.name)]
    stems = [PACKAGE.parent.joinpath(*name.split(".")) for name in names]
    files = [file for stem in stems for file in (stem.with_suffix(".py"), stem / "__init__.py")]
    looped = {
        own
        for pattern in LOOPS.get(str(path.relative_to(PACKAGE)), ())
        for own in PACKAGE.glob(pattern)
    }
    return {*filter(Path.is_file, files), *looped}


def in_library(paths: Iterable[str | Path]) -> list[Path]:
    """Return those of some files that belong to the library, which count as code of a step."""
    return [Path(path) for path in paths if Path(path).is_relative_to(PACKAGE)]


def steps_with(file: Path) -> list[str]:
    """Return the names of the steps that use a module of the library."""
    return [step for step in all_steps() if file.resolve() in modules_of_step(step)]


if __name__ == "__main__":
    print(*steps_with(Path(sys.argv[1])), sep="\n")
