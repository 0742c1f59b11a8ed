"""Writes docs/reference.md from signatures and docstrings:

./run python docs/make_reference.py
"""

import inspect
import re
from collections.abc import Callable, Collection, Iterator
from itertools import groupby
from pathlib import Path

import snapmap
from snapmap.device.device import Beam, Device
from snapmap.pulse.pulse import Pulse
from snapmap.study.variables import variables

PAGE = """\
# The functions, one by one

With this page you can look up every function of `snapmap`, its arguments and what it returns. Units
are um, ng and us, so uN, MPa, pJ, uN/um, ng/um^3, um/us^2 and 1/us; frequencies are in Hz, N in
multiples of g, the `gravity` of the device, C in uN us/um, temperatures in degC, thermal
coefficients in 1/K. Objects with units (pint, astropy, unyt) are refused, and variables of xarray
whose `units` are others.
Examples with a `device` begin with

```pycon
>>> device = snapmap.load_device("config/config.yaml")
```

## Shared arguments and options

Several functions take these; each names its options. A wrong argument raises ValueError or
TypeError with one line that names it. `calibrate`, `design` and `simulate` take a single device, N,
f0, C, shape and direction; the others take several as axes, `srs_test` only one direction.

- `device`: a Device, or several by name; `load_device` reads one
- `N`: amplitude of the shock, from 0
- `f0`: 1/duration of the shock, above 0; None for a recorded shock
- `C`: damping coefficient of the mass, from 0
- `model = "auto"`: a name, or a mapping of name and options, such as `reference` makes
- `horizon = 1500`: time followed after the pulse, from 0, us
- `energy_tolerance = 1e-3`: largest residual of the energy ledger over the pulse's work
- `threads = 1`: number of threads, at most 1024, which change no result
- `start = "first"`: shape in which the beam rests at first, or "second"
- `until = "settled"`: a run ends when it has settled in a well; "snap": or at its snap
- `repeat = True`: whether each cell runs again with another step; False if `until="snap"`
- `pulse = "versed sine"`: that, "half sine", "sawtooth", "trapezoid", or a Pulse
- `direction = "+z"`: +z presses the mass on the beam; others are "-z" and "both"
- `skip = False`: whether a device without a second stable shape is `absent`, not refused
- device axes: values of the device, such as `thickness=[1.9, 2.0]`, in internal units
- model options: [as in the config](config.md#model)

{functions}

## The cube

Its dimensions are axes of the device, `shape` and `direction` if several, C, f0 and N. Each
device's slice equals a run of that device alone, bit for bit. A cell *snaps* when the midpoint
first reaches the second equilibrium. With `start: second` the shapes change places.

Words of `outcome`:

- `never`, `latched`, `returned`: the run has settled: by its energy it stays for ever in the first 
  shape without a snap, in the second, or back in the first; another step may end elsewhere
- `unsnapped`, `snapped`: its state at the horizon; its future is open
- `failed`: the run diverged, or its energy ledger did not close
- `absent`: it has no second stable shape (`not_bistable: skip`)

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

## The classes

{values}
"""

RETURNED = {
    "sweep": "[The cube](#the-cube) lists the variables.",
    "threshold": "[Thresholds](thresholds.md) explains the variables.",
}
EXAMPLES = {
    "calibrate": "applications/calibration",
    "design": "applications/design",
    "plot_outcome": "own-physics",
    "read_pulse": "recipes",
    "reference": "own-physics",
    "srs_test": "applications/spectra",
    "statics": "applications/statics",
    "tolerance": "applications/tolerances",
    "vibration": "applications/spectra",
}
"""Another page that has an example of a function."""
DEVICE = '>>> device = snapmap.load_device("config/config.yaml")\n'
"""The first line of examples, which the page has once."""
MODULES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")


def reference() -> str:
    """The text of docs/reference.md."""
    public = {name: getattr(snapmap, name) for name in snapmap.__all__}
    functions = {name: what for name, what in public.items() if not isinstance(what, type)}
    values = {kind.__name__: kind for kind in (Device, Beam, Pulse)}
    return PAGE.format(
        functions="\n\n".join(_section("##", name, what) for name, what in functions.items()),
        values="\n\n".join(_section("###", name, what) for name, what in values.items()),
    )


def _section(level: str, name: str, described: Callable) -> str:
    text, _, example = inspect.getdoc(described).replace(DEVICE, "").partition("\n\n>>> ")
    parts = [f"{level} `{name}`"]
    parts += [_signature(described)] if inspect.isfunction(described) else []
    parts += _paragraphs(text, inspect.signature(described).parameters)
    parts += [RETURNED[name]] if name in RETURNED else []
    parts += [_variables()] if name == "simulate" else []
    if page := EXAMPLES.get(name):
        parts.append(f"Example: [{Path(page).name}]({page}.md).")
    elif example:
        parts.append(f"```pycon\n>>> {example}\n```")
    return "\n\n".join(parts)


def _variables() -> str:
    """Which variable of a history has which unit."""
    units = {}
    for key, about in variables("history").items():
        if key not in ("", "time"):
            units.setdefault(about.get("units", "a code"), []).append(f"`{key}`")
    listed = "; ".join(f"{', '.join(of)} ({unit})" for unit, of in units.items())
    return f"Variables over `time` (us), or without dimension: {listed}."


def _signature(function: Callable) -> str:
    """Its parameters and defaults, with the name of what it returns."""
    signature = inspect.signature(function)
    bare = [part.replace(annotation=part.empty) for part in signature.parameters.values()]
    parameters = str(signature.replace(parameters=bare, return_annotation=signature.empty))
    returned = MODULES.sub("", inspect.formatannotation(signature.return_annotation))
    code = f"{function.__name__}{parameters} -> {returned}".replace("'", '"')
    return f"```python\n{code}\n```"


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
