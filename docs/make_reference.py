"""Writes docs/reference.md from signatures and docstrings:

PYTHONPATH=workflow/scripts ./run python docs/make_reference.py
"""

import inspect
import re
from collections.abc import Callable, Collection, Iterator
from itertools import groupby
from pathlib import Path

import snapmap
from snapmap.device import Beam, Device
from snapmap.motion.history import VARIABLES
from snapmap.solver.settings import Settings

PAGE = """\
# The functions, one by one

Everything works in µm, ng and µs, so µN, MPa and pJ; frequencies are in Hz, and N in multiples
of g. Recipes are [here](recipes.md). This page comes from the docstrings, by

    PYTHONPATH=workflow/scripts ./run python docs/make_reference.py

{functions}

## What they take

{values}
"""

RETURNED = {
    "sweep": "What the variables are: [the cube](../README.md#the-cube).",
    "threshold": "What the variables are: [thresholds](thresholds.md).",
    "tolerance": "What the variables are: [devices as made](tolerances.md#what-comes-out).",
    "simulate": "The variables, over `time` (us):\n\n"
    + "\n".join(f"- `{key}`: {what}, {unit}" for key, (what, unit) in VARIABLES.items()),
}
MODULES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")


def reference() -> str:
    """The text of docs/reference.md."""
    functions = {name: getattr(snapmap, name) for name in snapmap.__all__}
    values = {kind.__name__: kind for kind in (Device, Beam, Settings)}
    return PAGE.format(
        functions="\n\n".join(_section("##", name, what) for name, what in functions.items()),
        values="\n\n".join(_section("###", name, what) for name, what in values.items()),
    )


def _section(level: str, name: str, described: Callable) -> str:
    text, _, example = inspect.getdoc(described).partition("\n\n>>> ")
    parts = [f"{level} `{name}`"]
    parts += [_signature(described)] if inspect.isfunction(described) else []
    parts += _paragraphs(text, inspect.signature(described).parameters)
    parts += [RETURNED[name]] if name in RETURNED else []
    parts += [f"```pycon\n>>> {example}\n```"] if example else []
    return "\n\n".join(parts)


def _signature(function: Callable) -> str:
    """As ruff would format it, one parameter a line, types without their modules."""
    signature = inspect.signature(function)
    parameters = "".join(f"    {parameter},\n" for parameter in signature.parameters.values())
    returned = inspect.formatannotation(signature.return_annotation)
    code = MODULES.sub("", f"def {function.__name__}(\n{parameters}) -> {returned}: ...")
    return "```python\n" + code.replace("'", '"') + "\n```"


def _paragraphs(text: str, names: Collection[str]) -> Iterator[str]:
    """Those of a docstring; lines that begin with the names of parameters become a list."""
    name = rf"(?:{'|'.join(names)})(?: \([^)]+\))?"
    entry = rf"{name}(?:, {name})*: "
    lines = re.sub(r"\n {4,}", " ", text).splitlines()
    for is_entry, group in groupby(lines, key=lambda line: bool(re.match(entry, line))):
        if is_entry:
            items = [item for line in group for item in re.split(f"; (?={entry})", line)]
            yield "\n".join(f"- {_code_in_head(item, names)}" for item in items)
        else:
            yield "\n".join(group).strip()


def _code_in_head(item, names):
    head, _, body = item.partition(": ")
    return re.sub(rf"\b({'|'.join(names)})\b", r"`\1`", head) + f": {body}"


if __name__ == "__main__":
    (Path(__file__).parent / "reference.md").write_text(reference(), encoding="utf-8")
