"""The schema of a config, and a line for each place where a document breaks it."""

import math
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path

import yaml
from jsonschema import Draft202012Validator, ValidationError, validators

from .quantity_keys import write_out
from .units import read, show

_LONGEST_KEY = 40
_MOST_KNOWN = 16
"""Keys that a message lists; of more the nearest."""


def schema_faults(document: Mapping) -> dict[tuple, str]:
    """Say where a document breaks the schema: lines by path."""
    errors = validator().iter_errors(document)
    return {
        path: f"{name_of(path)}: {message}" for error in errors for path, message in _explain(error)
    }


def _explain(error) -> Iterator[tuple[tuple, str]]:
    path, value, schema = tuple(error.absolute_path), error.instance, error.schema
    known = schema.get("properties", {})
    if error.validator == "required":
        for key in error.validator_value:
            if key not in value:
                yield (*path, key), f"missing; write {known[key]['description']}"
    elif error.validator == "additionalProperties":
        for key in value:
            if key not in known:
                yield (*path, key), f"unknown key; known here are {_nearest(key, list(known))}"
    elif error.validator == "format":
        yield path, error.message
    elif "format" not in schema:
        yield path, f"{show(value)} is not {schema['description']}"


def _nearest(key, known):
    if len(known) <= _MOST_KNOWN:
        return ", ".join(known)
    nearest = get_close_matches(str(key)[:_LONGEST_KEY], known, _MOST_KNOWN, 0)
    return f"{', '.join(nearest)} and {len(known) - len(nearest)} others"


def name_of(path: tuple) -> str:
    """device.beam.span, sweep.f0[2]; the document itself is `config`."""
    name = ""
    for key in path:
        plain = isinstance(key, str) and key.isidentifier() and len(key) <= _LONGEST_KEY
        name += f".{key}" if plain else f"[{show(key, _LONGEST_KEY)}]"
    return name.removeprefix(".") or "config"


def order_of(path: tuple) -> list[str]:
    """A key that sorts paths, list places as numbers."""
    return [f"{key:07d}" if isinstance(key, int) else str(key) for key in path]


@cache
def validator() -> Draft202012Validator:
    """Read the schema and write out its quantities; `format` names the kind of each."""
    text = Path(__file__).with_name("schema.yaml").read_text(encoding="utf-8")
    schema = yaml.safe_load(text)
    write_out(schema)
    types = Draft202012Validator.TYPE_CHECKER.redefine_many(
        {
            "object": lambda _, value: isinstance(value, Mapping),
            "array": lambda _, value: isinstance(value, list | tuple),
            "integer": lambda _, value: type(value) is int,
            "number": lambda _, value: type(value) in (int, float) and abs(value) < math.inf,
        }
    )
    strict = validators.extend(Draft202012Validator, {"format": _check_format}, type_checker=types)
    return strict(schema)


def _check_format(validator, kind, value, schema):
    try:
        read(value, kind)
    except ValueError as error:
        yield ValidationError(str(error))
