"""All that a study may say, as a page of tables: docs/settings.md."""

import json
from collections.abc import Iterator
from typing import Any

from ur5lib.study.explanation import allowed, branches
from ur5lib.study.model import Study

Schema = dict[str, Any]

HEAD = """\
# Settings

Made by `make schema` from the model in `ur5lib/study/model.py`; do not edit. Units are the suffixes
of the names (`cutoff_hz`), else in brackets. Keys of other names are refused.
"""


def settings_text() -> str:
    """Every key of a study: what is allowed, its default, what it does. Markdown."""
    schema = Study.model_json_schema()
    parts = sorted(_parts(schema), key=lambda part: part[0].split(".")[0])
    return "\n".join([HEAD, *(_section(*part) for part in parts)])


def _parts(schema: Schema) -> Iterator[tuple[str, str, Schema]]:
    """The study and each part of it once: the keys that lead there first, its kind, itself."""
    waiting, seen = [("", "", schema)], set()
    for path, kind, part in waiting:  # grows while it is walked through
        yield path, kind, part
        for key, node in part["properties"].items():
            for suffix, its, name in _named(node):
                if name not in seen:
                    seen.add(name)
                    place = f"{path}.{key}{suffix}".lstrip(".")
                    waiting.append((place, its, schema["$defs"][name]))


def _named(node: Schema) -> Iterator[tuple[str, str, str]]:
    """The parts that a key may hold: [] where there are many, how kinds are told apart, name."""
    if "$ref" in node:
        yield "", "", node["$ref"].rsplit("/", 1)[-1]
    for kind, option in branches(node).items():
        if "$ref" in option:
            told = f", {node['discriminator']['propertyName']}: {kind}"
            yield "", told, option["$ref"].rsplit("/", 1)[-1]
    for option in node.get("anyOf", []):
        yield from _named(option)
    if "items" in node:
        yield from (("[]" + suffix, kind, name) for suffix, kind, name in _named(node["items"]))


def _section(path: str, kind: str, part: Schema) -> str:
    title = f"`{path}`{kind}" if path else "The study"
    rows = "\n".join(_row(key, node, part) for key, node in part["properties"].items())
    head = "| key | allowed | default | what it is |\n| --- | --- | --- | --- |"
    return f"## {title}\n\n{part['description'].splitlines()[0]}\n\n{head}\n{rows}\n"


def _row(key: str, node: Schema, part: Schema) -> str:
    cells = [f"`{key}`", _allowed(node), _default(key, node, part), node.get("description", "")]
    return f"| {' | '.join(cells)} |"


def _default(key: str, node: Schema, part: Schema) -> str:
    """A key's default, or that it must be given, where need be unless others are."""
    if key in part.get("required", []):
        return "required"
    choices = [option["required"] for option in part.get("oneOf", [])]
    if any(key in choice for choice in choices):
        others = [f"`{other}`" for choice in choices if key not in choice for other in choice]
        return f"required, or {' and '.join(others)}"
    if any(_named(node)) or node.get("default") is None:
        return ""
    return f"`{json.dumps(node['default'])}`"


def _allowed(node: Schema) -> str:
    """What a key may hold, less the null that stands for leaving it out."""
    options = [option for option in node.get("anyOf", [node]) if option.get("type") != "null"]
    if any("$ref" in option for option in options):
        return "a mapping, below"
    return allowed(options[0]) + (", below" if any(_named(node)) else "")
