"""Which tests a change can reach: by the names that definitions use, and the files that tests name.

A test reaches its function, its fixtures, every function, class and constant that these use,
directly or not, and what a module does when it is imported. Nothing is imported to find out.
"""

import ast
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import chain
from pathlib import Path, PurePosixPath
from typing import NamedTuple, TypeGuard

from tests.conftest import PROJECT
from ur5lib.jobs.code import all_steps, module_of
from ur5lib.jobs.syntax import form_of
from ur5lib.workspace.beside import entry_points

ALL = "*"  # every name of a module
IMPORT = ""  # what a module does when it is imported
# All that decorators do here concerns what they decorate; others enter it somewhere.
PLAIN = re.compile(
    r"(functools\.|contextlib\.|pytest\.mark\.)?"
    r"(pytest\.fixture(?!.*autouse)|mark|parametrize|slow|thorough|real_time|usefixtures"
    r"|filterwarnings|xfail|skipif|cache|lru_cache|dataclass|contextmanager|given|settings|example)"
    r"|app\.command"
)
METHODS = {"property", "cached_property", "staticmethod", "classmethod", "override"}
OWN_BASES = {"NamedTuple", "Protocol", "Generic", "ABC"}  # which call no method by themselves
PAGE = PurePosixPath("ur5lib/report/page")  # reads the sections of topics, too
A_RUN = ("", "a run of Snakemake")
ANY = "."  # a method of whatever class
# Files that every test reads.
EVERYWHERE = {"pyproject.toml", "requirements.lock", "requirements-dev.lock", "tests/session.py"}
RUNS_COMMANDS = re.compile(r"\brun_ur5\b|\bCommand\b|\bcli\b|\.ur5\(|\bur5 [a-z]")
DOTTED = re.compile(r"\bur5(?:lib|lab|rivals)(?:\.[a-z_]\w*)+")


class Name(NamedTuple):
    """A name that a module defines; of no module, a file's text."""

    module: str
    name: str


class Module:
    """A Python file's definitions by name, and where its other names come from."""

    def __init__(self, module: str, text: str, modules: Iterable[str]) -> None:
        self.module, self.text = module, text
        self.parts: dict[str, list[ast.stmt]] = defaultdict(list)
        self.origins: dict[str, Name] = {}
        tree = ast.parse(text)
        for statement in tree.body:
            self._take(statement)
        runs = tree.body if module == "ur5lib" else [*filter(_runs, tree.body)]
        for node in chain.from_iterable(map(ast.walk, runs)):
            self.origins |= dict(_imported(node, modules))

    def _take(self, statement: ast.stmt) -> None:
        names = _defined(statement)
        if isinstance(statement, ast.ClassDef) and _calls_none_itself(statement):
            methods = [own for own in statement.body if _is_method(own)]
            for own in methods:
                self.parts[f"{statement.name}.{own.name}"].append(own)
            statement.body = [own for own in statement.body if own not in methods]
        if isinstance(statement, ast.ClassDef) and ast.get_docstring(statement, clean=False):
            del statement.body[0]  # which tests read as a text, if at all
        for name in names:
            self.parts[name].append(statement)

    def forms(self) -> dict[str, str]:
        """Of each name, its definition without comments and docstrings."""
        return {
            name: "".join(form_of(own) for own in parts if not isinstance(own, IMPORTS))
            for name, parts in self.parts.items()
        }


IMPORTS = ast.Import, ast.ImportFrom


def _runs(statement: ast.stmt) -> bool:
    return not (isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING")


def _defined(statement: ast.stmt) -> list[str]:
    """The names that a statement of a module defines, one that acts in another way none."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        acts = [own for own in statement.decorator_list if not PLAIN.match(ast.unparse(own))]
        return [statement.name, *([IMPORT] if acts else [])]
    targets = getattr(statement, "targets", [getattr(statement, "target", None)])
    named = [own.id for own in targets if isinstance(own, ast.Name)]
    return named if len(named) == len(targets) else [IMPORT]


def _is_method(own: ast.stmt) -> TypeGuard[ast.FunctionDef]:
    """Whether one runs only where its name is used."""
    if not isinstance(own, ast.FunctionDef) or own.name.startswith("__"):
        return False
    return all(ast.unparse(decorator) in METHODS for decorator in own.decorator_list)


def _calls_none_itself(own: ast.ClassDef) -> bool:
    """Whether no base of a class, which may be another package's, calls its methods."""
    return all(ast.unparse(base).partition("[")[0] in OWN_BASES for base in own.bases)


def _imported(node: ast.AST, modules: Iterable[str]) -> Iterator[tuple[str, Name]]:
    if isinstance(node, ast.Import):
        for own in node.names:
            whole = own.name if own.asname else own.name.partition(".")[0]
            yield own.asname or whole, Name(whole, ALL)
    if isinstance(node, ast.ImportFrom):
        for own in node.names:
            inner = f"{node.module}.{own.name}"
            found = Name(inner, ALL) if inner in modules else Name(str(node.module), own.name)
            yield own.asname or own.name, found


def _dotted(node: ast.AST) -> str | None:
    """A name with its attributes, as it is written."""
    if isinstance(node, ast.Attribute):
        whole = _dotted(node.value)
        return whole and f"{whole}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else None


def _used(node: ast.AST) -> Iterator[str]:
    """The names that a statement uses, with their attributes."""
    if whole := _dotted(node):
        yield whole
        return
    for inner in ast.iter_child_nodes(node):
        yield from _used(inner)


class Project:
    """The project's modules and files, and which name uses which."""

    def __init__(self, folder: Path = PROJECT) -> None:
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        told = subprocess.check_output(listed, cwd=folder, text=True).splitlines()
        self.files = [file for file in told if (folder / file).is_file()]
        paths = {module_name(file): file for file in self.files if file.endswith(".py")}
        texts = {name: (folder / file).read_text() for name, file in paths.items()}
        self.paths = paths
        self.modules = {name: Module(name, text, paths) for name, text in texts.items()}

    @cached_property
    def uses(self) -> dict[Name, set[Name]]:
        """Of each name, those that it uses, whatever class a method is of."""
        found = defaultdict[Name, set[Name]](set)
        for user, used in chain(self._uses(), self._unwritten_uses(), self._uses_of_data()):
            found[user].add(used)
        return found

    @cached_property
    def reaching(self) -> dict[Name, int]:
        """Of each name the tests that reach it, a bit each.

        A test reaches a method if it reaches its class, and a use of a method with its name.
        """
        found = defaultdict[Name, int](int)
        found |= {test: 1 << place for place, test in enumerate(self.tests)}
        new = dict.fromkeys(self.tests)  # in their order, each once
        while new:
            del new[user := next(iter(new))]
            reached = [(used, found[user]) for used in self.uses.get(user, ())]
            for method in self._methods_of.get(user, ()):
                owner, name = _class_and_method(method)
                reached.append((method, found[owner] & found[name]))
            for used, tests in reached:
                if tests & ~found[used]:
                    found[used] |= tests
                    new[used] = None
        return found

    @cached_property
    def _methods_of(self) -> dict[Name, set[Name]]:
        """The methods of each class, and those of each name."""
        found = defaultdict[Name, set[Name]](set)
        for name, module in self.modules.items():
            for method in (Name(name, part) for part in module.parts if "." in part):
                for of in _class_and_method(method):
                    found[of].add(method)
        return found

    @cached_property
    def names(self) -> list[str]:
        """The tests as pytest names them, without their parameters."""
        return [f"{self.paths[own.module]}::{own.name}" for own in self.tests]

    def reached(self, changed: Iterable[Name]) -> set[str]:
        """The tests that reach a name."""
        bits = 0
        for name in changed:
            bits |= self.reaching.get(name, 0)
        return {own for place, own in enumerate(self.names) if bits >> place & 1}

    @cached_property
    def tests(self) -> list[Name]:
        parts = (Name(name, own) for name, module in self.modules.items() for own in module.parts)
        return [own for own in parts if _is_test(own)]

    def _uses(self) -> Iterator[tuple[Name, Name]]:
        for name, module in self.modules.items():
            for part, statements in module.parts.items():
                user = Name(name, part)
                yield Name(name, ALL), user
                yield user, Name(name, IMPORT)
                for used in chain.from_iterable(self._used_by(module, own) for own in statements):
                    yield user, used
                if owner := part.rpartition(".")[0]:
                    yield user, Name(name, owner)
            if name == "ur5lib":
                yield from ((Name(name, ALL), own) for own in module.origins.values())

    def _used_by(self, module: Module, statement: ast.stmt) -> Iterator[Name]:
        for whole in _used(statement):
            if found := self._origin(module, whole.split(".")):
                yield found
        called = {node.attr for node in ast.walk(statement) if isinstance(node, ast.Attribute)}
        if "getattr(" in (written := ast.unparse(statement)):
            called |= {*_texts(statement)}
        yield from (Name(ANY, own) for own in called)
        if module.module == "ur5lib.cli":
            return  # a command is one that is named
        for topic in re.findall(r"modules_of_topics\('(\w+)'\)", written):
            yield from self._all_of("ur5lib.topics.", f".{topic}")
        if module.module.startswith("tests."):
            yield from self._used_by_tests(module, statement)

    def _used_by_tests(self, module: Module, statement: ast.stmt) -> Iterator[Name]:
        """Fixtures by their names; modules and files that are named in texts."""
        conftests = [own for own in self._conftests(module.module) if own != module.module]
        yield from (Name(own, IMPORT) for own in conftests)
        texts = {*_texts(statement)}
        fixtures = texts if "usefixtures" in ast.unparse(statement) else set[str]()
        if isinstance(statement, ast.FunctionDef) and _asks_for_fixtures(statement):
            fixtures |= {own.arg for own in statement.args.args}
        if RUNS_COMMANDS.search(module.text):
            yield from (self.commands[own] for own in texts & self.commands.keys())
            named = chain.from_iterable(re.findall(r"\bur5 ([a-z]+)", own) for own in texts)
            yield from (self.commands[own] for own in named if own in self.commands)
        for name in fixtures:
            for own in [module.module, *conftests]:
                if name in self.modules[own].parts:
                    yield Name(own, name)
                    break
        for whole in chain.from_iterable(map(DOTTED.findall, texts)):
            package, *inner = whole.split(".")
            if found := self._followed(Name(package, ALL), inner):
                yield found
        yield from (Name("", file) for file in self._files_named(statement, texts))

    @cached_property
    def commands(self) -> dict[str, Name]:
        """The function of each command of `ur5`."""
        own = self.modules["ur5lib.cli"].parts.items()
        found = {
            name.rstrip("_"): Name("ur5lib.cli", name)
            for name, [statement, *_] in own
            if "app.command" in "".join(map(ast.unparse, getattr(statement, "decorator_list", ())))
        }
        for file in self.files:
            if topic := re.fullmatch(r"ur5lib/topics/(\w+)/command.py", file):
                found[topic[1]] = Name(module_name(file), ALL)
        for name, place in entry_points().items():
            found[name] = Name(*place.split(":"))
        return found

    def _conftests(self, name: str) -> list[str]:
        """The conftest modules that concern a module of tests, the nearest first."""
        folders = name.split(".")[:-1]
        above = [".".join([*folders[:end], "conftest"]) for end in range(len(folders), 0, -1)]
        return [own for own in above if own in self.modules]

    def _files_named(self, statement: ast.stmt, texts: Iterable[str]) -> Iterator[str]:
        """Files that a statement names, as a whole, by their folder, or by the end of a name."""
        for text in texts:
            folder = f"{text.rstrip('/')}/"
            if text in self.known:
                yield text
            elif folder in self.folders and not text.startswith("ur5"):
                yield from (file for file in self.known if file.startswith(folder))
        ends = {PurePosixPath(text).suffix for text in texts if "*" in text} - {"", ".*"}
        whole = ast.unparse(statement)
        for folder in {*re.findall(r"PROJECT((?: / '[\w.-]+')*)", whole)} if ends else ():
            begins = "/".join(re.findall(r"'([\w.-]+)'", folder))
            yield from (f for f in self.known if f.startswith(begins) and f.endswith(tuple(ends)))

    @cached_property
    def known(self) -> set[str]:
        return {*self.files}

    @cached_property
    def folders(self) -> set[str]:
        return {f"{above}/" for file in self.files for above in PurePosixPath(file).parents}

    def _origin(self, module: Module, whole: list[str]) -> Name | None:
        """The name that is meant by one with its attributes, if a module of the project has it."""
        first, *inner = whole
        if first in module.parts:
            return Name(module.module, first)
        return self._followed(module.origins[first], inner) if first in module.origins else None

    def _followed(self, meant: Name, inner: list[str]) -> Name | None:
        if meant.name == ALL and inner:
            whole = f"{meant.module}.{inner[0]}"
            inside = whole in self.modules
            following = Name(whole, ALL) if inside else Name(meant.module, inner[0])
            return self._followed(following, inner[1:])
        if meant.module not in self.modules:
            return None
        module = self.modules[meant.module]
        if meant.name in module.origins and meant.name not in module.parts:
            return self._followed(module.origins[meant.name], inner)
        return meant

    def _all_of(self, begins: str, ends: str = "") -> Iterator[Name]:
        found = (own for own in self.modules if own.startswith(begins) and own.endswith(ends))
        return (Name(own, ALL) for own in found)

    def _unwritten_uses(self) -> Iterator[tuple[Name, Name]]:
        """What is used by names that a program puts together."""
        run = Name(*A_RUN)
        steps = [Name(module_name(module_of(own)), own) for own in all_steps()]
        for user in (run, Name("ur5lib.jobs.job", "step_named")):
            yield from ((user, own) for own in steps)
        yield Name("tests.warm_snakemake", "snakemake"), run
        yield Name("ur5lib.workspace.places", "SNAKEFILE"), run
        for module, name, begins, ends in (
            ("ur5lib.report.page.handed", "", "ur5lib.report.views.", ""),
            ("ur5rivals.estimators", "all_estimators", "ur5rivals.estimators.", ""),
            ("tests.fuzz", "targets", "tests.", ".fuzzed"),
            ("tests.house.test_benchmarks", "", "benchmarks.", ""),
        ):
            yield from ((Name(module, name), own) for own in self._all_of(begins, ends))
        rules = [file for file in self.files if file.endswith((".smk", "Snakefile"))]
        for file in rules:
            named = DOTTED.findall((PROJECT / file).read_text())
            meant = [self._followed(Name("ur5lib", ALL), own.split(".")[1:]) for own in named]
            yield from ((run, own) for own in meant if own)
            yield run, Name("", file)

    def _uses_of_data(self) -> Iterator[tuple[Name, Name]]:
        """A package's modules read the files that lie with them."""
        beside = defaultdict[PurePosixPath, list[str]](list)
        for name, file in self.paths.items():
            beside[PurePosixPath(file).parent].append(name)
        for file in self.files:
            folders = PurePosixPath(file).parents
            near = next((own for own in folders if own in beside), None)
            if near and not file.endswith(".py") and not file.startswith("tests/"):
                page = beside[PAGE] if file.endswith(".typ") else []
                for reader in self._readers([*beside[near], *page], file):
                    yield reader, Name("", file)

    def _readers(self, modules: Iterable[str], file: str) -> list[Name]:
        """The definitions that name a file, or its ending; all that there are if none does."""
        path = PurePosixPath(file)
        ending = path.suffix or path.name
        parts = ((own, *part) for own in modules for part in self.modules[own].parts.items())
        named = [
            Name(module, part)
            for module, part, statements in parts
            if any(path.name in text or ending in text for text in _texts(*statements))
        ]
        return named or [Name(module, IMPORT) for module in modules]


def module_name(file: str | Path) -> str:
    """The name by which a file of the project is imported."""
    inside = Path(file).relative_to(PROJECT) if Path(file).is_absolute() else Path(file)
    return ".".join(inside.with_suffix("").parts).removesuffix(".__init__")


def _is_test(own: Name) -> bool:
    return own.module.split(".")[-1].startswith("test_") and own.name.startswith("test_")


def _class_and_method(own: Name) -> tuple[Name, Name]:
    """Its class, and a use of its name."""
    owner, _, name = own.name.partition(".")
    return Name(own.module, owner), Name(ANY, name)


def _asks_for_fixtures(function: ast.FunctionDef) -> bool:
    decorators = "".join(map(ast.unparse, function.decorator_list))
    return function.name.startswith("test_") or "fixture" in decorators


def _texts(*statements: ast.stmt) -> Iterator[str]:
    for node in chain.from_iterable(map(ast.walk, statements)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def changed_names(file: str, before: str | None, after: str | None) -> set[Name]:
    """What of a file changed, its text with it; None where the file is absent."""
    names = {Name("", file)}
    if file.endswith(".py"):
        module = module_name(file)
        old, new = (Module(module, text or "", ()).forms() for text in (before, after))
        names |= {Name(module, own) for own in old.keys() | new if old.get(own) != new.get(own)}
    return names
