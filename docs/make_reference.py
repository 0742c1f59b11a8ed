"""Writes docs/reference.md from signatures and docstrings:

./run python docs/make_reference.py
"""

import inspect
import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import reduce
from itertools import groupby
from pathlib import Path
from typing import Union, get_args, get_origin, get_type_hints

import snapmap
from snapmap.device.argument import argument_of
from snapmap.device.device import VALUES, Beam, Device
from snapmap.device.quantities import QUANTITIES
from snapmap.public import options_of
from snapmap.solver.settings import Settings
from snapmap.study.variables import variables

PAGE = """\
# The functions, one by one

Units are µm, ng and µs, so µN, MPa and pJ; frequencies are in Hz, N in multiples of g, C in
uN us/um. `model` is a name, or the config's model section; a `device` that may be a mapping is one,
or several by name, as an axis. [Recipes](recipes.md) show them at work. This page comes from the
docstrings, by

    ./run python docs/make_reference.py

{functions}

## The cube

Its dimensions are the axes of the device, in the order of the config, `shape` and `direction` if
there are several, then C, f0 and N. Each slice is, bit for bit, what that device gives alone. A
cell *snaps* when the midpoint first reaches the second equilibrium; with `start: second` it is the
first, and both shapes change places here.

| `outcome` | means | known by |
|---|---|---|
| `never` | did not snap and never will | energy: less than the barrier is left |
| `latched` | snapped and stays in the second shape | energy of all, or of the beam alone |
| `returned` | snapped and stays in the first shape | energy |
| `unsnapped`, `snapped` | so at the horizon; what follows is open | simulation |
| `failed` | the run diverged, or its energy ledger did not close | the ledger |
| `absent` | no second stable shape (`not_bistable: skip`) | Q = rise/thickness |

| other variables | what |
|---|---|
| `t_snap`, `t_settled` | times of the snap and of the proof; us after the pulse's start, NaN if \
there is none; attribute `label_distance`: how far from a threshold, relative, a label can be \
wrong ([accuracy](accuracy.md)) |
| `blow` | of a train or drop: number of the blow that snaps, from 1; else 0 |
| `well`, `well_share` | side of the saddle on which the beam ends, and share of the mass's last \
swing there: 1 where proven; 0 and NaN of `reference`; not with `until: snap` |
| `energy_error` | residual of the energy ledger over the gross work of the pulse |
| `pulse_work` | work of the whole pulse on mass and beam, pJ; NaN where the run ended before |
| `halvings` | how often the step was halved until the ledger closed |
| `reproduced`, `well_reproduced` | 1 if a run with another step had the same outcome; ended on \
the same side |
| `work_error`, `t_snap_error` | indicators, no bounds: differences to that run, of the work (over \
the larger of both) and of the time of snap (us) |
| `t_closed`, `closed_for`, `openings`, `closed_share` | with `contact_at`, each with its \
`_error`: [electrode](applications/electrode.md) |
| `level`, `agreed` | of `auto`: the level that decided, 0 or 1, and whether levels \
disagreed, 0, agreed, 1, or but one looked, 2 |

Attributes hold the config, the versions of code and packages, the shares of proven and open
cells, and about how many labels can be wrong.

## What they take

### Arguments and options

Beside options of the model. Functions with `skip` take values of the device, too, as axes, in their
units. A wrong argument raises ValueError or TypeError with one line that names it.

| name | what it may be | of |
|---|---|---|
{arguments}

{values}
"""

RETURNED = {
    "sweep": "What the variables are: [the cube](#the-cube).",
    "threshold": "What the variables are: [thresholds](thresholds.md).",
    "tolerance": "What the variables are: [tolerances](applications/tolerances.md).",
    "simulate": "The variables, over `time` (us):\n\n"
    + "\n".join(
        f"- `{key}`: {about['long_name']}, {about['units']}"
        for key, about in variables("history").items()
        if key not in ("", "time")
    ),
}
MODULES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")


def reference() -> str:
    """The text of docs/reference.md."""
    functions = {name: getattr(snapmap, name) for name in snapmap.__all__}
    values = {kind.__name__: kind for kind in (Device, Beam, Settings)}
    return PAGE.format(
        functions="\n\n".join(_section("##", name, what) for name, what in functions.items()),
        arguments="\n".join(_arguments(functions)),
        values="\n\n".join(_section("###", name, what) for name, what in values.items()),
    )


def _section(level: str, name: str, described: Callable) -> str:
    text, _, example = inspect.getdoc(described).partition("\n\n>>> ")
    parts = [f"{level} `{name}`"]
    parts += [_signature(described)] if inspect.isfunction(described) else []
    parts += _paragraphs(text, inspect.signature(described).parameters)
    parts += [RETURNED[name]] if name in RETURNED else []
    parts += [_units(described)] if is_dataclass(described) else []
    parts += [f"```pycon\n>>> {example}\n```"] if example else []
    return "\n\n".join(parts)


def _arguments(functions: Mapping[str, Callable]) -> Iterator[str]:
    """Rows of a table of arguments: what each may be, and of which functions."""
    rows = {}
    for name, function in functions.items():
        parameters = inspect.signature(function).parameters
        kinds = {key: parameters[key].annotation for key in parameters if key != "options"}
        arguments = {key: argument_of(kind) for key, kind in kinds.items()}
        for key, argument in (arguments | options_of(function)).items():
            if key not in VALUES:
                rows.setdefault((key, argument.need), []).append(f"`{name}`")
    for (key, need), names in sorted(rows.items()):
        yield f"| `{key}` | {need.replace(', nor ', ', or ')} | {', '.join(names)} |"


def _units(kind: type) -> str:
    """Which of its values has which unit."""
    units = {}
    for field in fields(kind):
        if unit := QUANTITIES[field.name].unit if field.name in QUANTITIES else "":
            units.setdefault(unit, []).append(f"`{field.name}`")
    return "Units: " + "; ".join(f"{unit} of {', '.join(of)}" for unit, of in units.items()) + "."


def _signature(function: Callable) -> str:
    """As ruff would format it, one parameter a line, types without their modules."""
    signature, types = inspect.signature(function), get_type_hints(function)
    parameters = ""
    for name, parameter in signature.parameters.items():
        kind = parameter.empty if name == "options" else types[name]
        kind = reduce(operator.or_, get_args(kind)) if get_origin(kind) is Union else kind
        parameters += f"    {parameter.replace(annotation=kind)},\n"
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
