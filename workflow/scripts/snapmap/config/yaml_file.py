"""A config file as a plain mapping: YAML without its surprises."""

import re
import sys
from collections.abc import Mapping
from pathlib import Path

import yaml

from ..io.named import read_named
from .units import show

CONFIG = 300_000, "write axes as from, to, points"
"""Bytes that a config may have, and what to do about more: YAML is slow to read."""
_DEEPEST, _MOST_PARTS = 8, 3_000_000
_LONGEST_NUMBER = 60
_SURPRISE = re.compile(r".*[:_]|[+-]?0[^.]")
"""In a number that YAML does not take for what it looks like: 1:30:00 is 5400, and 010 is 8."""


class ConfigError(ValueError):
    """Faults of a config, one line each in `args`; its text is these lines."""

    def __str__(self):
        return "\n".join(self.args)


def read_document(path: str | Path) -> dict:
    """Read a YAML file that holds one mapping without repeated keys; raises ConfigError."""
    try:
        text = read_named(path, *CONFIG).decode("utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is no text in UTF-8") from None
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from None
    try:
        document = yaml.load(text, Loader=_Loader)
    except RecursionError:
        reason = "is nested deeper than any key of a config"
        raise ConfigError(f"{path}: not valid YAML: {reason}") from None
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1
        raise ConfigError(f"{path}: line {line} is not valid YAML: {error.problem}") from None
    except Exception as error:  # PyYAML lets errors of several types through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ConfigError(f"{path}: not valid YAML: {reason}") from None
    if not isinstance(document, dict):
        raise ConfigError(f"{path}: {show(document)} is not a mapping of device, model, sweep")
    if "__use_yte__" in document:  # by which Snakemake would evaluate expressions
        raise ConfigError(f"{path}: __use_yte__ is not allowed; write values, not expressions")
    return document


def unwieldy_part(document: Mapping) -> tuple[tuple, str] | None:
    """The first part too deep, too large or too long to be quoted, and a complaint; None if none.

    A few lines of YAML can hold themselves, or a billion parts, by aliases.
    """
    parts, seen = [((), document)], 0
    while parts:
        path, value = parts.pop()
        seen += 1
        if seen > _MOST_PARTS:
            return (), f"has more than {_MOST_PARTS} parts; write fewer, axes as from, to, points"
        if isinstance(value, int) and value.bit_length() > 10_000:
            return path, "has thousands of digits; write a shorter number"
        if isinstance(value, str) and _is_broken(value):
            return path, f"{show(value)} has half a character; write whole ones"
        if isinstance(value, Mapping | list | tuple | set) and len(path) > _DEEPEST:
            return path[:_DEEPEST], "is nested deeper than any key of a config; write a value"
        if isinstance(value, Mapping):
            parts += [(path, key) for key in value if isinstance(key, int | str | tuple)]
            parts += [((*path, key), part) for key, part in value.items()]
        elif isinstance(value, list | tuple):
            parts += [((*path, place), part) for place, part in enumerate(value)]
    return None


def _is_broken(text):
    """Whether it has a lone surrogate, which no file can be written with."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return True
    return False


class _Loader(yaml.SafeLoader):
    """Refuses equal keys, of which PyYAML keeps the last, and numbers that are not decimal."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if key.value in seen:
                problem = f"{show(key.value)} comes twice"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_decimal(self, node):
        text = self.construct_scalar(node)
        if _SURPRISE.match(text) or len(text) > _LONGEST_NUMBER:
            problem = f"{show(text)} is no plain decimal number"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        kind = "int" if node.tag.endswith("int") else "float"
        return getattr(self, f"construct_yaml_{kind}")(node)


for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _Loader.construct_decimal)


if __name__ == "__main__":  # for `run`, before Snakemake evaluates what a config says
    try:
        for _path in sys.argv[1:]:
            read_document(_path)
    except ConfigError as _error:
        sys.exit(str(_error))
