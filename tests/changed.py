"""Run the tests that a change can reach, and say what is left out.

The change is that of the working folder since REV: by default since the branch left origin/main,
without such a branch since the last commit. Which tests it reaches is told by names (tests.reach),
from the code alone: what is called by a name that a program puts together may be missed. `make
test` runs all.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections import Counter

from tests.conftest import PROJECT
from tests.reach import EVERYWHERE, Project, changed_names

SECONDS = PROJECT / ".pytest_cache" / "v" / "processor"  # of each test, from the last run of all
REAL_TIME = ["-m", "real_time and not thorough", "--numprocesses", "1"]
OTHERS = ["-m", "not real_time and not thorough"]
NONE_FOUND = 5  # pytest's status where all tests are deselected


def git(*arguments: str) -> str | None:
    """What git prints, None if it fails."""
    done = subprocess.run(["git", *arguments], cwd=PROJECT, capture_output=True, check=False)
    return None if done.returncode else done.stdout.decode(errors="replace")


def left_main() -> str:
    """The commit from which on the change counts, if none is named."""
    return (git("merge-base", "HEAD", "origin/main") or "HEAD").strip()


def reached_since(project: Project, revision: str) -> set[str]:
    """The tests that the change of the working folder since a commit reaches."""
    tracked = (git("diff", "--name-only", "--no-renames", revision) or "").splitlines()
    new = (git("ls-files", "--others", "--exclude-standard") or "").splitlines()
    paths = {file: PROJECT / file for file in {*tracked, *new}}
    texts = {f: p.read_text(errors="replace") if p.is_file() else None for f, p in paths.items()}
    return reached(
        project, {file: (git("show", f"{revision}:{file}"), texts[file]) for file in paths}
    )


def reached_by(project: Project, commit: str) -> set[str]:
    """The tests of today that the change of a commit reaches."""
    listed = git("diff-tree", "-r", "--no-commit-id", "--name-only", commit) or ""
    before, after = f"{commit}~", commit
    texts = {
        file: (git("show", f"{before}:{file}"), git("show", f"{after}:{file}"))
        for file in listed.splitlines()
    }
    return reached(project, texts)


def reached(project: Project, texts: dict[str, tuple[str | None, str | None]]) -> set[str]:
    """The tests that a change of files reaches; texts: of each before and after."""
    if texts.keys() & EVERYWHERE:
        return {*project.names}
    return project.reached(set().union(*(changed_names(file, *own) for file, own in texts.items())))


def seconds(project: Project) -> Counter[str]:
    """Processor time of each test [s] in the last run of all; a second where it is not known."""
    took: Counter[str] = Counter()
    for name, spent in json.loads(SECONDS.read_text()).items() if SECONDS.exists() else ():
        took[name.partition("[")[0]] += spent
    return took if took else Counter(dict.fromkeys(project.names, 1))


def share(chosen: set[str], took: Counter[str], project: Project) -> float:
    return sum(took[own] for own in chosen) / sum(took[own] for own in project.names)


def account(chosen: set[str], project: Project) -> str:
    """How many tests run, and of which folders others are left out."""
    left = Counter(own.partition("::")[0].split("/")[1] for own in {*project.names} - chosen)
    folders = ", ".join(f"{name.removesuffix('.py')} {n}" for name, n in left.most_common())
    of_time = f"{share(chosen, seconds(project), project):.0%} of the time of all"
    return (
        f"{len(chosen)} of {len(project.names)} tests can be reached, {of_time}; "
        f"left out: {folders or 'none'}; and those marked thorough"
    )


def run(chosen: set[str]) -> int:
    """Run tests as `make test` does: those in real time one by one."""
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as listed:
        listed.write("\n".join(sorted(chosen)))
        listed.flush()
        command = [sys.executable, "-m", "pytest", f"@{listed.name}"]
        ended = [subprocess.call([*command, *how], cwd=PROJECT) for how in (OTHERS, REAL_TIME)]
    return next((status for status in ended if status not in (0, NONE_FOUND)), 0)


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m tests.changed", description=__doc__)
    options.add_argument("--since", metavar="REV", default=left_main())
    options.add_argument("--list", action="store_true", help="name the tests, run none")
    options.add_argument("--shares", metavar="REV", nargs="+", help="of all tests' time, by commit")
    given = options.parse_args()
    project = Project()
    if given.shares:
        took = seconds(project)
        shares = {own: share(reached_by(project, own), took, project) for own in given.shares}
        print(*(f"{commit} {part:.3f}" for commit, part in shares.items()), sep="\n")
        print(f"median {statistics.median(shares.values()):.3f}")
        return
    chosen = reached_since(project, given.since)
    print(account(chosen, project), file=sys.stderr)
    if given.list:
        print(*sorted(chosen), sep="\n")
    elif chosen:
        sys.exit(run(chosen))


if __name__ == "__main__":
    main()
