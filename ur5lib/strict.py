"""Data that people write by hand: their base class, their files, and words for mistakes."""

import re
import stat
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict
from pydantic_core import ErrorDetails

from ur5lib.errors import InputError, perhaps

# Limit on a file's bytes, 20 times those of a study of a thousand recordings.
MOST_BYTES = 5_000_000
# Limit on a file's values, 3 times those of a study of a thousand recordings.
MOST_VALUES = 100_000
MAX_LEVELS = 50  # levels of lists and mappings; a study has 8
MAX_NUMBER_LENGTH = 100  # characters
MAX_PATH_BYTES, MAX_PART_BYTES = 1000, 255  # bytes of a path, and of a name in it
SNAKEMAKE_PLACEHOLDER = re.compile(r"\{\s*[.\w]+\s*[,}]|<[a-z]\w*>")  # Snakemake replaces it
MERGE_TAG = "tag:yaml.org,2002:merge"  # tag of the key <<, which may occur several times
FAST_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's, if installed
FAST_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
QUOTE = "'"  # around a discriminator's name in messages of pydantic
SPECIAL_FILE_KINDS = {
    stat.S_ISFIFO: "a named pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}
# Keys that people expect but that do not exist, with what to do instead.
INSTEAD_OF = dict.fromkeys(
    ("exclude_joints", "ignore_joints", "skip_joints"),
    "a force loads all joints, so that none can be left out; remove the key, and overrule a stop "
    "sign of one joint by `accept`, with its kind and the reason",
)

Schema = dict[str, Any]  # a node of a JSON schema


class Strict(BaseModel):
    """A part of a hand-written file: unknown keys are errors, and an instance does not change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def usable_path(path: str) -> str:
    """Return the path. Raises ValueError if no file can have it, or Snakemake would change it."""
    longest = max(len(part.encode(errors="replace")) for part in path.split("/"))
    if "\0" in path or longest > MAX_PART_BYTES or len(path) > MAX_PATH_BYTES:
        raise ValueError(
            f"a path of at most {MAX_PATH_BYTES:,} bytes, each name in it at most {MAX_PART_BYTES}"
        )
    if SNAKEMAKE_PLACEHOLDER.search(path):
        raise ValueError(
            "a path without a word in {} or <>, which Snakemake would replace; rename the file or "
            "folder"
        )
    return path


PathText = Annotated[str, AfterValidator(usable_path)]


def existing_file(path: str) -> str:
    """Return the path. Raises ValueError if there is no such file."""
    if not Path(usable_path(path)).is_file():
        kind = _special_kind(Path(path))
        raise ValueError(f"a file, not {kind}" if kind else "an existing file")
    return path


def expect_file(path: Path) -> None:
    """Raise InputError for a pipe, socket or device, which may block forever."""
    if kind := _special_kind(path):
        raise InputError(
            f"{path} is {kind}, which cannot be read as a file; save its content in a file and "
            "name that one"
        )


def _special_kind(path: Path) -> str | None:
    """Return the kind of a path that is neither file nor folder, None for others."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return None
    return next((kind for is_kind, kind in SPECIAL_FILE_KINDS.items() if is_kind(mode)), None)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file as plain data.

    Raises as `read_text` and `plain_yaml`.
    """
    return plain_yaml(read_text(path), str(path))


def read_text(path: Path) -> str:
    """Return the text of a file that people write by hand.

    Raises OSError or UnicodeDecodeError when it cannot be read, InputError when it is not a file,
    or is too large.
    """
    expect_file(path)
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path} has more than {MOST_BYTES:,} bytes; divide it")
    return path.read_text(encoding="utf-8")


def plain_yaml(text: str, source: str) -> Any:
    """Return the content of YAML as plain data.

    Raises yaml.YAMLError if it is not YAML, InputError if it has a key twice, an invalid number, or
    is too large.
    """
    try:
        _expect_few_levels(text, source)  # before libyaml, which crashes on a deep nest
        return _plain_data(FAST_LOADER(text), source)
    except yaml.YAMLError:  # for a message that shows the line
        return _plain_data(yaml.SafeLoader(text), source)


def _expect_few_levels(text: str, source: str) -> None:
    """Raise InputError where a text of YAML is nested too deep, or has too many values."""
    level = 0
    for count, event in enumerate(yaml.parse(text, FAST_LOADER)):
        level += isinstance(event, yaml.CollectionStartEvent)
        level -= isinstance(event, yaml.CollectionEndEvent)
        if level > MAX_LEVELS:
            raise _too_deep(source)
        if count > 3 * MOST_VALUES:  # a list has a start event and an end event
            raise _too_many(source)


def _plain_data(loader: Any, source: str) -> Any:
    """Return the content of a YAML loader as plain data."""
    try:
        if (node := loader.get_single_node()) is None:
            return None
        expect_few_values(node, source)
        for part in _nodes(node):
            if isinstance(part, yaml.MappingNode):
                _expect_keys_once(part, source)
            elif isinstance(part, yaml.ScalarNode) and part.tag != MERGE_TAG:
                _expect_value(part, loader, source)
        return loader.construct_document(node)
    except RecursionError as error:
        raise _too_deep(source) from error
    finally:
        loader.dispose()


def _nodes(node: yaml.Node) -> Iterator[yaml.Node]:
    """Yield a node of YAML and all below it, each once."""
    waiting, met = [node], {id(node)}
    while waiting:
        yield (node := waiting.pop())
        for part in _parts(node):
            if id(part) not in met:
                met.add(id(part))
                waiting.append(part)


def _expect_keys_once(node: yaml.MappingNode, source: str) -> None:
    """Raise InputError where a mapping has a key twice: one of its values would vanish."""
    lines: dict[str, int] = {}
    for key, _ in node.value:
        if not isinstance(key, yaml.ScalarNode) or key.tag == MERGE_TAG:
            continue
        if key.value in lines:
            raise InputError(
                f"{_place(key, source)}: `{key.value}` is in line {lines[key.value]} already, "
                "and one of its two values would be lost; join them, or remove one"
            )
        lines[key.value] = key.start_mark.line + 1


def _expect_value(node: yaml.ScalarNode, loader: Any, source: str) -> None:
    """Raise InputError for an invalid number, date or truth value.

    The loader caches the valid ones, so that they are not constructed twice.
    """
    try:
        value = loader.construct_object(node)
        sound = not isinstance(value, int) or len(node.value) <= MAX_NUMBER_LENGTH
    except yaml.YAMLError:
        raise
    except Exception:  # PyYAML lets through whatever a conversion raises
        sound = False
    if not sound:
        raise InputError(
            f"{_place(node, source)}: {node.value[:20]!r} ({len(node.value):,} characters) is no "
            "number, date or truth value that can be used; correct it, or quote it if it is text"
        )


def _place(node: yaml.Node, source: str) -> str:
    return f"{source}, line {node.start_mark.line + 1}"


def expect_few_values(data: Any, source: str) -> None:
    """Raise InputError where data are nested too deep, or huge through repeated aliases.

    data: plain data, or the nodes of a YAML file; source: its name, for the message. An alias
    (`*name`) repeats the content of its anchor: nine lines can give a thousand million values.
    """
    if _measure(data, 0, {}, source)[0] > MOST_VALUES:
        raise _too_many(source)


def _measure(
    data: Any, level: int, measured: dict[int, tuple[int, int]], source: str
) -> tuple[int, int]:
    """Return the number of values in data and the number of levels below; measured: the same pair
    for parts already counted, by id.
    """
    if level + measured.get(id(data), (1, 0))[1] > MAX_LEVELS:
        raise _too_deep(source)
    if id(data) not in measured:
        below = [_measure(part, level + 1, measured, source) for part in _parts(data)]
        count = 1 + sum(count for count, _ in below)
        measured[id(data)] = count, 1 + max((depth for _, depth in below), default=-1)
    return measured[id(data)]


def _parts(data: Any) -> Sequence[Any]:
    """Return the direct parts of a list, a mapping or a node of YAML."""
    if isinstance(data, yaml.MappingNode):
        return [part for pair in data.value for part in pair]
    if isinstance(data, dict):
        return [*data, *data.values()]
    if isinstance(data, yaml.SequenceNode):
        return list(data.value)
    return data if isinstance(data, list | tuple) else ()


def _too_many(source: str) -> InputError:
    return InputError(
        f"{source} has more than {MOST_VALUES:,} values (an alias, `*name`, counts as all that it "
        "names); divide it"
    )


def _too_deep(source: str) -> InputError:
    return InputError(
        f"{source} nests lists and mappings more than {MAX_LEVELS} levels deep; flatten it"
    )


def explain(error: ErrorDetails, schema: Schema) -> str:
    """Return one sentence for one of pydantic's errors: key, value, allowed values, closest valid
    name.
    """
    location, node = _descend(schema, error["loc"])
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    key, kind = "".join(parts).lstrip("."), error["type"]
    if kind == "extra_forbidden":
        keys = _descend(schema, error["loc"][:-1])[1]["properties"]
        if len(location) == 1 and "settings" in keys:
            of_settings = _descend(schema, ("settings",))[1].get("properties", {})
            if key in of_settings:
                return f"`{key}` belongs under `settings`; write it there, indented"
        if instead := INSTEAD_OF.get(str(location[-1])):
            return f"unknown key `{key}`: {instead}"
        return f"unknown key `{key}`{perhaps(location[-1], keys)}; known keys: {', '.join(keys)}"
    if kind.startswith("union_tag"):
        return _explain_tag(error, key, list(branches(node)))
    if kind == "missing":
        return f"`{key}` is missing; give {allowed(node)}"
    if kind == "no_description":
        return f"`{key}`: {error['msg']}"
    if kind == "of_entry":
        return f"`{key}` {error['msg']}"
    if kind == "value_error" and "properties" in node:  # an error of several keys together
        return f"`{key}`: {error['ctx']['error']}" if key else str(error["ctx"]["error"])
    near = perhaps(error["input"], _choices(node))
    remedy = error["ctx"]["error"] if kind == "value_error" else allowed(node)
    hint = " (in quotes, or YAML does not read it as text)" if kind == "string_type" else ""
    return f"`{key}` is {quoted(error['input'])}{near}; give {remedy}{hint}"


def _explain_tag(error: ErrorDetails, key: str, tags: list[str]) -> str:
    """Explain a wrong or missing `format` or `kind`, which selects the kind of a part."""
    key = f"{key}.{error['ctx']['discriminator'].strip(QUOTE)}"
    remedy = f"give one of {', '.join(tags)}"
    if error["type"] == "union_tag_not_found":
        return f"`{key}` is missing; {remedy}"
    value = error["ctx"]["tag"]
    return f"`{key}` is {value!r}{perhaps(value, tags)}; {remedy}"


def _descend(schema: Schema, location: Iterable[str | int]) -> tuple[list[str | int], Schema]:
    """Return the keys that lead to an erroneous value, and the JSON schema node of that value.

    location: of the value, as pydantic gives it: keys, indices of lists, and names of kinds, which
    are left out of the returned keys.
    """
    node, keys = schema, list[str | int]()
    for part in location:
        kinds = branches(node)
        if part in kinds:
            node = kinds[str(part)]
        else:
            keys.append(part)
            node = _child(node, part)
        node = _present(node)
        if "$ref" in node:
            node = schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
    return keys, node


def branches(node: Schema) -> dict[str, Schema]:
    """Return the alternatives of a schema node: by the tag that selects one, else by their JSON
    types.
    """
    mapping = node.get("discriminator", {}).get("mapping", {})
    options = node.get("oneOf", [])
    tagged = {t: option for option in options for t in mapping if mapping[t] == option.get("$ref")}
    return tagged or {option.get("type", "object"): option for option in options}


def _present(node: Schema) -> Schema:
    """Return the schema node of an optional value without its alternative null; others
    unchanged.
    """
    options = [option for option in node.get("anyOf", []) if option.get("type") != "null"]
    return options[0] if len(options) == 1 else node


def _child(node: Schema, part: str | int) -> Schema:
    """Return the schema node of a key of a mapping, or of an entry of a list by its index."""
    if isinstance(part, str):
        return node.get("properties", {}).get(part, node.get("additionalProperties") or {})
    entries = node.get("prefixItems", [])
    return entries[part] if part < len(entries) else node.get("items", {})


def quoted(value: object) -> str:
    """Return a value for messages, shortened if it is long."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _choices(node: Schema) -> list[str]:
    return [str(value) for value in node.get("enum", [node["const"]] if "const" in node else [])]


def allowed(node: Schema) -> str:
    """Return the values that a JSON schema node allows, in words: "a number above 0"."""
    if choices := _choices(node):
        return "one of " + ", ".join(choices)
    bounds = {
        "minimum": "at least",
        "exclusiveMinimum": "above",
        "maximum": "at most",
        "exclusiveMaximum": "below",
        "minItems": "with at least",
    }
    limits = [f"{word} {node[key]}" for key, word in bounds.items() if key in node]
    if "minItems" in node:
        limits = [f"{limits[0]} {'entry' if node['minItems'] == 1 else 'entries'}"]
    if "maxItems" in node:
        limits = [f"of {node['maxItems']}"]
    type_ = "object" if "discriminator" in node else node.get("type", "value")
    kind = {"array": "a list", "object": "a mapping"}.get(type_, f"a {type_}")
    if "pattern" in node:
        limits.append(f"of {node['characters']}")
    return f"{kind.replace('a integer', 'an integer')} {' and '.join(limits)}".strip()
