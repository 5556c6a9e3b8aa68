"""Error messages about a study: key, value, allowed values, closest valid name."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from pydantic_core import ErrorDetails

QUOTE = "'"  # pydantic puts it around a discriminator's name


def explain(error: ErrorDetails, schema: dict[str, Any]) -> str:
    """Return one sentence for one error: key, value, allowed values, closest valid name."""
    location, node = _descend(schema, error["loc"])
    key, kind = _key(location), error["type"]
    if kind == "extra_forbidden":
        known = _descend(schema, error["loc"][:-1])[1]["properties"]
        return f"unknown key `{key}`{_near(location[-1], known)}; known keys: {', '.join(known)}"
    if kind.startswith("union_tag"):
        return _explain_tag(error, key, list(branches(node)))
    if kind == "missing":
        return f"`{key}` is missing; give {allowed(node)}"
    if kind == "no_description":
        return f"`{key}`: {error['msg']}"
    near = _near(error["input"], _choices(node))
    wanted = error["ctx"]["error"] if kind == "value_error" else allowed(node)
    return f"`{key}` is {shown(error['input'])}{near}; give {wanted}"


def _explain_tag(error: ErrorDetails, key: str, tags: list[str]) -> str:
    """Explain a wrong or missing `format` or `kind`, which selects the kind of a part."""
    key = f"{key}.{error['ctx']['discriminator'].strip(QUOTE)}"
    remedy = f"give one of {', '.join(tags)}"
    if error["type"] == "union_tag_not_found":
        return f"`{key}` is missing; {remedy}"
    value = error["ctx"]["tag"]
    return f"`{key}` is {value!r}{_near(value, tags)}; {remedy}"


def _key(location: Iterable[str | int]) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).lstrip(".")


def _descend(
    schema: dict[str, Any], location: Iterable[str | int]
) -> tuple[list[str | int], dict[str, Any]]:
    """Return the keys of a location, without tags of kinds, and the schema node there."""
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


def branches(node: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the kinds of a part by tag; where two types are allowed, the types."""
    mapping = node.get("discriminator", {}).get("mapping", {})
    options = node.get("oneOf", [])
    tagged = {t: option for option in options for t in mapping if mapping[t] == option.get("$ref")}
    return tagged or {option.get("type", "object"): option for option in options}


def _present(node: dict[str, Any]) -> dict[str, Any]:
    """Return the schema node of a value that may be omitted."""
    options = (option for option in node.get("anyOf", []) if {"$ref", "oneOf"} & set(option))
    return next(options, node)


def _child(node: dict[str, Any], part: str | int) -> dict[str, Any]:
    """Return the schema node of a key, or of an entry of a list."""
    if isinstance(part, str):
        return node.get("properties", {}).get(part, node.get("additionalProperties") or {})
    entries = node.get("prefixItems", [])
    return entries[part] if part < len(entries) else node.get("items", {})


def _near(value: object, candidates: Iterable[str]) -> str:
    matches = get_close_matches(str(value), list(candidates), n=1, cutoff=0.5)
    return f" (did you mean `{matches[0]}`?)" if matches else ""


def shown(value: object) -> str:
    """Return a value for messages, shortened if it is long."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _choices(node: dict[str, Any]) -> list[str]:
    return node.get("enum", [node["const"]] if "const" in node else [])


def allowed(node: dict[str, Any]) -> str:
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
