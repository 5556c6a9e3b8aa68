"""The file of an arm: what is damaged is refused, by NumPy, C++ and the schema alike."""

import copy
import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tests.conftest import PROJECT
from tests.topics.live.made_arm import exported, samples
from ur5lib.topics.live.live import FORMAT, Live

HEADER = PROJECT / "ur5lib" / "topics" / "live"
VERDICTS = """
#include <cstdio>
#include "live.hpp"
int main(int count, char** paths) {
  for (int k = 1; k < count; ++k) try {
    live::Live::load(paths[k]);
    std::puts("taken");
  } catch (const std::runtime_error&) {
    std::puts("refused");
  }
}
"""
NUMBERS = (None, True, "1", [], {}, np.nan, np.inf, -np.inf, 0.0, -1.0, -1e-12, 1e-300, 1e300, 5)
Damage = Callable[[str, np.random.Generator], str]


def right_file() -> dict[str, Any]:
    """Return the file of an arm, with parts that the estimator does not read."""
    return {"format": "", "arm": 'a \u00e9 " [[[', "judged_on": [], **exported()} | {
        "threshold": {"log_odds": 3.0, "false_per_min": 0.2, "minutes": 5.0},
        "smallest_pushes": [{"value": None}],
        "gravity": [0.0, 0.1, -9.8],
    }


def leaves(value: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the places of all parts of a file."""
    parts = [*value.items()] if isinstance(value, dict) else [*enumerate(value)]
    found = []
    for key, own in parts:
        found.append((*place, key))
        if isinstance(own, dict | list):
            found += leaves(own, (*place, key))
    return found


def with_change(text: str, random: np.random.Generator, change: Callable[[Any, Any], None]) -> str:
    """Return a file with a change of one of its parts, drawn among keys first, then further in."""
    arm = json.loads(text)
    value, places = arm, leaves({key: arm[key] for key in exported()})
    *way, key = places[random.integers(len(places))]
    for one in way:
        value = value[one]
    change(value, key)
    return json.dumps(arm)


def other_number(text: str, random: np.random.Generator) -> str:
    chosen = NUMBERS[random.integers(len(NUMBERS))]

    def change(parent: Any, key: Any) -> None:
        while isinstance(parent[key], dict | list):
            parent = parent[key]
            key = [*parent][random.integers(len(parent))] if isinstance(parent, dict) else 0
        parent[key] = chosen

    return with_change(text, random, change)


def without(text: str, random: np.random.Generator) -> str:
    return with_change(text, random, lambda parent, key: parent.pop(key))


def longer(text: str, random: np.random.Generator) -> str:
    def change(parent: Any, key: Any) -> None:
        if isinstance(parent, list):
            parent.append(copy.deepcopy(parent[key]))
        else:
            parent[key] = [parent[key], parent[key]]

    return with_change(text, random, change)


def cut(text: str, random: np.random.Generator) -> str:
    return text[: random.integers(len(text))]


def other_byte(text: str, random: np.random.Generator) -> str:
    data = bytearray(text.encode())
    data[random.integers(len(data))] = random.choice([*b'[]{},:"\\ 0.-eNx\x00\t\x80\xc3\xed'])
    return data.decode("utf-8", "surrogateescape")


def replaced(*pairs: tuple[str, str]) -> Damage:
    def damage(text: str, random: np.random.Generator) -> str:
        old, new = pairs[random.integers(len(pairs))]
        assert old in text
        return text.replace(old, new, 1)

    return damage


DAMAGES: tuple[Damage, ...] = (other_number, other_number, without, longer, cut, other_byte)
DAMAGES += (
    replaced(
        (FORMAT, "ur5lib live 3"),
        ('"format": ', '"format" '),
        ('"mass": ', '"mass": 0'),
        ('"mass": ', '"mass": +'),
        ('"mass": ', '"mass": 1.0, "mass": '),
        ('"mass": ', '"m\\u0061ss": '),
        ('"mass": ', '"m\\x61ss": '),
        ('"gravity": [', '"gravity": [,'),
        ('"gravity": [', '"gravity": [0x10, '),
        ('"gravity": [0.0, ', '"gravity": [1' + 5000 * "0" + ", "),
        ('"gravity": [0.0, ', '"gravity": [1e999, '),
        ('"gravity": [0.0, ', '"gravity": [-0, '),
        ('"gravity": [0.0, ', '"gravity": [.0, '),
        ('"gravity": ', '"gravity.0": 1.0, "gravity": '),
        ('"judged_on": []', '"judged_on": ' + 14 * "[" + 14 * "]"),
        ('"judged_on": []', '"judged_on": ' + 16 * "[" + 16 * "]"),
        ('"judged_on": []', '"judged_on": [1' + 5000 * "0" + "]"),
        ('"judged_on": []', '"judged_on": [Infinity]'),
        ('"judged_on": []', '"judged_on": ["\\ud800", "\\/\\b"]'),
        ('"judged_on": []', '"judged_on": [true, false, null]'),
        ('"judged_on": []', '"judged_on": [truer]'),
        ('"judged_on": []', '"judged_on": ["\t"]'),
        ('{"format"', '\ufeff{"format"'),
        ('{"format"', '\r\n\t {"format"'),
        ('{"format"', '\v{"format"'),
        ('"load": [', '"load": [25.0, '),
        ('"sizes": [', '"size": ['),
        ('"input": "current"', '"input": []'),
    ),
    lambda text, random: text + str(random.choice(["}", " \n", "\x00", "{}", "//", "\f"])),
    lambda _, random: 200_000 * str(random.choice(["[", '{"a":', '["', "[1,"])),
)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> Callable[[list[Path]], list[str]]:
    """What the compiled header says of files."""
    if (compiler := shutil.which("g++")) is None:
        pytest.skip("no g++ is installed, so the header is not compared with the reference")
    folder = tmp_path_factory.mktemp("verdicts")
    (folder / "verdicts.cpp").write_text(VERDICTS)
    flags = ["-std=c++17", f"-I{HEADER}", "-o", folder / "verdicts"]
    subprocess.run([compiler, folder / "verdicts.cpp", *flags], check=True)

    def said(paths: list[Path]) -> list[str]:
        done = subprocess.run([folder / "verdicts", *paths], capture_output=True, check=True)
        return done.stdout.decode().split()

    return said


@pytest.mark.parametrize("flag", ["-ffast-math", "-ffinite-math-only"])
def test_the_header_is_not_compiled_without_nan(flag: str, tmp_path: Path) -> None:
    if (compiler := shutil.which("g++")) is None:
        pytest.skip("no g++ is installed")
    (tmp_path / "empty.cpp").write_text('#include "live.hpp"\n')
    command = [compiler, "-std=c++17", "-E", flag, f"-I{HEADER}", tmp_path / "empty.cpp"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "compile it without -ffast-math" in done.stderr


def verdict(path: Path) -> str:
    """What the reference says of a file; one that it takes has finite answers."""
    try:
        estimator = Live.load(path)
    except ValueError:
        return "refused"
    run = samples(0.4, moving=True)
    for sample in zip(run.time, run.q, run.qd, run.current, strict=True):
        answer = estimator.step(*sample)
        assert np.isfinite([*answer.wrench, *answer.std]).all()
    return "taken"


def test_damaged_files_have_the_same_verdict_in_both(
    verdicts: Callable[[list[Path]], list[str]], tmp_path: Path
) -> None:
    text = json.dumps(right_file(), ensure_ascii=False)
    files = [tmp_path / f"{seed}.json" for seed in range(401)]
    files[0].write_text(text)
    for seed, path in enumerate(files[1:]):
        damaged = DAMAGES[seed % len(DAMAGES)](text, np.random.default_rng(seed))
        path.write_bytes(damaged.encode("utf-8", "surrogateescape"))
    own = [verdict(path) for path in files]
    differing = [p.name for p, a, b in zip(files, own, verdicts(files), strict=True) if a != b]
    assert not differing
    assert own[0] == "taken"
    assert own.count("refused") > 250
    assert own.count("taken") > 20
    schema = json.loads((HEADER / "live.schema.json").read_text())
    read = {**schema, "required": [*exported()], "additionalProperties": True}
    read["properties"] = {key: schema["properties"][key] for key in read["required"]}
    for path, said in zip(files, own, strict=True):
        if said == "taken":
            jsonschema.validate(json.loads(path.read_text("utf-8"), parse_int=float), read)
