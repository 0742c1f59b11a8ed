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
from snapmap.io.variables import variables
from snapmap.solver.settings import Settings

PAGE = """\
# The functions, one by one

Everything works in µm, ng and µs, so µN, MPa and pJ; frequencies are in Hz, and N in multiples
of g. Recipes are [here](recipes.md). This page comes from the docstrings, by

    PYTHONPATH=workflow/scripts ./run python docs/make_reference.py

{functions}

## The cube

Its dimensions are the axes of the device, in the order of the config, `shape` and `direction` if
there are several, then C (uN us/um), f0 (Hz) and N (multiples of g). Each slice is, bit for bit,
what that device gives alone. A cell *snaps* when the midpoint first reaches the second equilibrium.

| `outcome` | means | known by |
|---|---|---|
| `never` | did not snap and never will | energy: less than the barrier is left |
| `latched` | snapped and stays in the second shape for ever | energy of all, or of the beam, \
parted from the mass |
| `returned` | snapped and is back in the first shape for ever | energy |
| `unsnapped`, `snapped` | so at the horizon; what follows is open | simulation |
| `failed` | the run blew up or its energy ledger did not close | the ledger |
| `absent` | no second stable shape (only with `not_bistable: skip`) | Q = rise/thickness |

| other variables | what |
|---|---|
| `t_snap`, `t_settled` | when it snapped, and when it was seen to be settled; us after the \
pulse's start, NaN if not; the attribute `label_distance`: \
how far, relative, from a well-posed threshold a label can be \
[wrong](accuracy.md#steps-by-question) |
| `blow` | of a train of blows, a drop or a sweep: number of the one that snaps, from 1; else 0 |
| `well`, `well_share` | side of the saddle on which the beam is at the end of its run, and the \
share of the mass's last swing spent there: 1 where it is proven; 0 and NaN with the model \
`reference`, whose runs end at their snap; not with `until: snap` |
| `energy_error` | residual of the energy ledger over the gross work of the pulse; about \
1e-13 in coarse steps as in fine ones, but for `reference` |
| `pulse_work` | work of the whole pulse on mass and beam, pJ; NaN where the run ended before its \
pulse, at a snap, or failed |
| `halvings` | how often the step was halved until the ledger closed; histories and traces take \
the same step |
| `reproduced`, `well_reproduced` | 1 if a run with another step had the same outcome, and 1 if it \
ended on the same side; what did not, and no longer goes back and forth, is hatched on the maps of \
ends |
| `work_error`, `t_snap_error` | indicators, no bounds: difference of the work of the pulse (over \
the larger of both) and of the time of snap (us) in that other run: how far \
[the motion](accuracy.md#the-motion-after-the-snap) is known; a history has both as attributes |
| `level`, `agreed` | of the model `auto`: the level that decided, 0 or 1, and whether no two that \
did disagree |

Attributes hold the config, the versions of code and packages, and the shares of proven and open
cells.

## What they take

{values}
"""

RETURNED = {
    "sweep": "What the variables are: [the cube](#the-cube).",
    "threshold": "What the variables are: [thresholds](thresholds.md).",
    "tolerance": "What the variables are: [devices as made](devices.md).",
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
