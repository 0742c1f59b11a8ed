"""Config files are read as plain mappings: YAML without its surprises."""

import re
from pathlib import Path

import yaml

from ..files.named import naming, read_named
from ..files.text import describe
from ..values.faults import Faults

CONFIG = 300_000, "write axes as from, to, points"
"""Most bytes of a config, as YAML is slow to read, and the remedy for more."""
_SURPRISE = re.compile(r".*[:_]|[+-]?0[^.]")
"""Pattern of a number that YAML reads as another: 1:30:00 as 5400, and 010 as 8."""


def read_document(path: str | Path) -> dict:
    """Read a YAML file that is a mapping without repeated keys; raises Faults."""
    try:
        with naming(path):
            return _mapping(read_named(path, *CONFIG).decode("utf-8"))
    except ValueError as error:
        raise Faults(str(error)) from None


def _mapping(text):
    try:
        document = yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1
        raise ValueError(f"line {line} is not valid YAML: {error.problem}") from None
    except Exception as error:  # PyYAML lets errors of several types through
        raise ValueError(f"not valid YAML: {str(error) or type(error).__name__}") from None
    if not isinstance(document, dict):
        raise ValueError(f"{describe(document)} is not a mapping of device, model, sweep")
    if "__use_yte__" in document:  # by which Snakemake would evaluate expressions
        raise ValueError("__use_yte__ is not allowed; write values, not expressions")
    return document


class _Loader(yaml.SafeLoader):
    """A loader that refuses equal keys, of which PyYAML keeps the last, and surprising numbers."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        keys = set()
        for key, _ in node.value:
            if key.value in keys:
                problem = f"{describe(key.value)} comes twice"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            keys.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_decimal(self, node: yaml.ScalarNode) -> int | float:
        text = self.construct_scalar(node)
        if _SURPRISE.match(text):
            problem = f"{describe(text)} is not a plain decimal number"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        kind = "int" if node.tag.endswith("int") else "float"
        return getattr(self, f"construct_yaml_{kind}")(node)


for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _Loader.construct_decimal)
