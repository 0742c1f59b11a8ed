"""A config file as a plain mapping: YAML without its surprises."""

from collections.abc import Mapping
from pathlib import Path

import yaml

from .units import show

_DEEPEST, _MOST_PARTS = 8, 3_000_000


class ConfigError(ValueError):
    """Faults of a config, one line each in `args`; its text is these lines."""

    def __str__(self):
        return "\n".join(self.args)


def read_document(path: str | Path) -> dict:
    """Read a YAML file that holds one mapping without repeated keys; raises ConfigError."""
    try:
        document = yaml.load(Path(path).read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
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
        if isinstance(value, Mapping | list | tuple | set) and len(path) > _DEEPEST:
            return path[:_DEEPEST], "is nested deeper than any key of a config; write a value"
        if isinstance(value, Mapping):
            parts += [(path, key) for key in value if isinstance(key, int | tuple)]
            parts += [((*path, key), part) for key, part in value.items()]
        elif isinstance(value, list | tuple):
            parts += [((*path, place), part) for place, part in enumerate(value)]
    return None


class _Loader(yaml.SafeLoader):
    """PyYAML keeps the last of two equal keys without a word; this one refuses them."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if key.value in seen:
                problem = f"{show(key.value)} comes twice"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)
