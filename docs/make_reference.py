"""Writes docs/reference.md from signatures and docstrings:

./run python docs/make_reference.py
"""

import inspect
import re
from collections.abc import Callable
from pathlib import Path

import snapmap
from snapmap.study.variables import variables

PAGE = """\
# The functions, one by one

With this page you can look up every function and class of `snapmap`; `help(snapmap.threshold)`
shows the same. Plain numbers are in um, ng and us, so uN, MPa, pJ, uN/um, ng/um^3, um/us^2 and
1/us; frequencies are in Hz, N in multiples of g, the `gravity` of the device, C in uN us/um,
temperatures in degC, thermal coefficients in 1/K. Text has its unit, as `"600 um"`, and objects
with units (pint, astropy, unyt, variables of xarray with `units`) are converted. Text of a plain
number, as `"0.001"`, is taken where a value has no unit.

A wrong value raises ValueError, with a line for each that names it; an argument that is missing or
unknown raises TypeError. Examples with a `device` begin with

```pycon
>>> device = snapmap.load_device("config/config.yaml")
```

{sections}

## The cube

Its dimensions are axes of the device, `shape` and `direction` if several, C, f0 and N. Each
device's slice equals a run of that device alone, bit for bit. A cell *snaps* when the midpoint
first reaches the second equilibrium. With `start: second` the shapes change places.

Words of `outcome`, whose codes are in its attributes:

- `never`, `latched`, `returned`: the run has settled: by its energy it stays for ever in the first 
  shape without a snap, in the second, or back in the first; another step may end elsewhere
- `unsnapped`, `snapped`: its state at the horizon; its future is open
- `failed`: the run diverged, or its energy ledger did not close
- `absent`: it has no second stable shape (`skip: true`)

Variables beside `outcome`:

- `t_snap`, `t_settled`: time of the snap, and time from which the run has settled, us after the 
  pulse's start, or NaN; attribute `label_distance` of `t_snap`: [a label can be 
  wrong](accuracy.md) so near a threshold, relative
- `blow`: number of the blow of a train or drop that snaps the beam, else 0
- `well`, `well_share`: side of the saddle where the beam ends, and share of the mass's last swing 
  there (1 where settled); 0 and NaN of `reference`; absent with `until: snap`
- `energy_error`: residual of the energy ledger over the pulse's gross work
- `pulse_work`: work of the pulse on mass and beam, pJ; NaN where the run ended earlier
- `halvings`: number of halvings of the step until the ledger closed
- `reproduced`, `well_reproduced`: 1 if a run with another step had the same outcome, or well
- `work_error`, `t_snap_error`: differences to that run in work (relative) and `t_snap` (us), not 
  bounds
- `t_closed`, `closed_for`, `openings`, `closed_share`: closures of an electrode, each with its 
  `_error` ([electrode](applications/electrode.md))
- `level`, `agreed`: level of `auto` that decided, 0 or 1; whether both levels agreed (1), 
  disagreed (0), or only one ran (2)

Attributes hold the config, versions of code and packages, shares of settled and open cells, the
numbers of cells that end elsewhere with another step and, estimated, of wrong labels.

## The history

Variables of `simulate` over `time` (us), or without dimension: {history}.
"""

DEVICE = '>>> device = snapmap.load_device("config/config.yaml")\n'
"""The first line of examples, which the page has once."""
ADDRESSES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")
HEADING = re.compile(r"\n\n(\w+)\n-{3,}\n")


def reference() -> str:
    """The text of docs/reference.md."""
    public = {name: getattr(snapmap, name) for name in snapmap.__all__}
    sections = (_section(name, what) for name, what in public.items())
    return PAGE.format(sections="\n\n".join(sections), history=_history())


def _section(name: str, described: Callable) -> str:
    """Its signature and the sections of its docstring."""
    head, *parts = HEADING.split(inspect.getdoc(described))
    lines = [f"## `{name}`", f"```python\n{_signature(name, described)}\n```", head]
    for title, text in zip(parts[::2], parts[1::2], strict=True):
        lines.append(f"**{title}**")
        is_code = title == "Examples"
        lines.append(f"```pycon\n{text.replace(DEVICE, '')}\n```" if is_code else _entries(text))
    return "\n\n".join(lines)


def _entries(text: str) -> str:
    """Make a list of the entries of a section of numpydoc."""
    entries = (entry.partition("\n") for entry in re.split(r"\n(?! )", text))
    return "\n".join(f"- {_code(head)}: {' '.join(body.split())}" for head, _, body in entries)


def _code(head: str) -> str:
    names, _, kind = head.partition(" : ")
    return f"`{names}`" + f" ({kind})" * bool(kind)


def _signature(name: str, described: Callable) -> str:
    """Parameters and defaults; what a function returns."""
    signature = inspect.signature(described)
    bare = [part.replace(annotation=part.empty) for part in signature.parameters.values()]
    called = signature.replace(parameters=bare, return_annotation=signature.empty)
    returned = ADDRESSES.sub("", inspect.formatannotation(signature.return_annotation))
    is_class = isinstance(described, type)
    text = f"class {name}{called}" if is_class else f"{name}{called} -> {returned}"
    return text.replace("'", '"')


def _history() -> str:
    """Which variable of a history has which unit."""
    units: dict[str, list[str]] = {}
    for key, about in variables("history").items():
        if key not in ("", "time"):
            units.setdefault(about.get("units", "a code"), []).append(f"`{key}`")
    return "; ".join(f"{', '.join(of)} ({unit})" for unit, of in units.items())


if __name__ == "__main__":
    (Path(__file__).parent / "reference.md").write_text(reference(), encoding="utf-8")
