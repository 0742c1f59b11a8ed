"""Writes docs/reference.md from signatures and docstrings:

./run python docs/make_reference.py
"""

import inspect
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import snapmap
from snapmap.study.variables import variables

PAGE = """\
# The functions, one by one

Here you can look up every function and class of `snapmap`
([glossary](tutorial.md#glossary)); `help(snapmap.threshold)` shows the same in one piece.

A plain number is in um, ng and us, and so in uN, MPa, pJ, uN/um, ng/um^3, um/us^2 and 1/us.
Frequencies are in Hz, temperatures in degC, thermal coefficients in 1/K. Text has its unit, as
`"600 um"`; objects with units (pint, astropy, unyt, xarray with `units`) are converted. A value
without unit may be text, too, as `"0.001"`.

Each function raises what follows, and what stands under it.

{wrong}
- `TypeError`: An argument is missing or unknown.

Examples with a `device` begin with

```pycon
>>> device = snapmap.load_device("config/config.yaml")
```

Several functions take these arguments, which their own lists leave out:

{shared}

{sections}

## The cube

Its dimensions are axes of the device, `shape` and `direction` if several, C, f0 and N. Each
device's slice equals a run of that device alone, bit for bit. With `start: second` the two shapes
change places.

`outcome` is a code, whose words its attributes hold. The [glossary](tutorial.md#glossary) explains
`never`, `latched`, `returned`, and `unsnapped` and `snapped`, which are open. `failed`: the run
diverged, or its energy ledger did not close. `absent`: the device has no second stable shape
(`skip: true`). Beside it are

- `t_snap`, `t_settled`: time of the snap, and time from which the run has settled, us after the 
  start of the pulse, or NaN; the attribute `label_distance` of `t_snap` says how near a threshold, 
  relative, [a label can be wrong](accuracy.md)
- `blow`: number of the pulse of a train or drop that snaps the beam, 0 if none
- `well`, `well_share`: side of the saddle where the beam ends, and share of the mass's last 
  vibration that it spends there (1 if settled); 0 and NaN with the model `reference`; absent with 
  `until: snap`
- `energy_error`: residual of the energy ledger over the pulse's gross work
- `pulse_work`: work of the pulse on mass and beam, pJ; NaN if the run ended earlier
- `halvings`: how often the step was halved until the ledger closed
- `reproduced`, `well_reproduced`: 1 if a run with another step had the same outcome, or `well`
- `work_error`, `t_snap_error`: differences to that run in work (relative) and `t_snap` (us), not 
  bounds
- `t_closed`, `closed_for`, `openings`, `closed_share`: closures of an electrode, each with its 
  `_error` ([electrode](applications/electrode.md))
- `level`: model of `auto` that decided, 0 the cheap or 1 the fine one; `agreed`: whether the two
  finer ones agreed (1), disagreed (0), or did not run (2)

Attributes hold the config, versions of code and packages, the numbers of cells of each outcome and
of those that end elsewhere with another step, and an estimate of how many labels are uncertain.

## The history

Variables of `simulate` over `time` (us), or without dimension: {history}.
"""

DEVICE = '>>> device = snapmap.load_device("config/config.yaml")\n'
"""The first line of examples, which the page has once."""
VERBS = {"Returns": "returns ", "Raises": "raises "}
WRONG = "- `ValueError`: A line for each argument that is wrong."
OTHER = "`ValueError`:"

KEYS = "The keys of [`{}`](config.md#{}) in a config"
MODEL = KEYS.format("model", "model") + "."
IN_CONFIG = {
    **dict.fromkeys(("Auto", "Cosines", "Elements", "Reference"), MODEL),
    "Beam": KEYS.format("device.beam", "devicebeam") + ", without `shape` and `quality_factor`.",
    "Device": KEYS.format("device", "device") + ", without `quality_factor`.",
}
"""Where the page of the config has the fields of a class, as keys of a section."""
ADDRESSES = re.compile(r"\b(?:[a-z_]\w*\.)+(?=[A-Z])")
HEADING = re.compile(r"\n\n(\w+)\n-{3,}\n")


def reference() -> str:
    """The text of docs/reference.md."""
    public = {name: _parts(getattr(snapmap, name)) for name in snapmap.__all__}
    entries = Counter(
        entry
        for name, parts in public.items()
        if name not in IN_CONFIG
        for entry in _entries(parts.get("Parameters", ""))
    )
    shared = [entry for entry, times in entries.items() if times > 2]
    sections = "\n\n".join(
        _section(name, parts, {*shared, WRONG}) for name, parts in public.items()
    )
    shared = "\n".join(shared)
    return PAGE.format(wrong=WRONG, shared=shared, sections=sections, history=_history())


def _parts(described: Callable) -> dict[str, str]:
    """The sections of its docstring by title, with the text before them under ""."""
    head, *parts = HEADING.split(inspect.getdoc(described))
    return {"": head} | dict(zip(parts[::2], parts[1::2], strict=True))


def _section(name: str, parts: dict[str, str], left_out: set[str]) -> str:
    """Its signature and the sections of its docstring, without entries that the page has above."""
    lines, listed = [f"## `{name}`", f"```python\n{_signature(name)}\n```", parts[""]], []
    for title in ("Parameters", "Returns", "Raises"):
        entries = (entry for entry in _entries(parts.get(title, "")) if entry not in left_out)
        said = (entry[2:].replace(WRONG[2:], OTHER) for entry in entries)
        listed += [f"- {VERBS.get(title, '')}{entry}" for entry in said]
    lines.append(IN_CONFIG.get(name, "\n".join(listed)))
    return "\n\n".join([*lines, f"```pycon\n{parts['Examples'].replace(DEVICE, '')}\n```"])


def _entries(text: str) -> list[str]:
    """Make items of a list of the entries of a section of numpydoc."""
    entries = (entry.partition("\n") for entry in re.split(r"\n(?! )", text) if entry)
    return [f"- {_code(head)}: {' '.join(body.split())}" for head, _, body in entries]


def _code(head: str) -> str:
    names, _, kind = head.partition(" : ")
    return f"`{names}`" + f" ({kind})" * bool(kind)


def _signature(name: str) -> str:
    """Parameters and defaults; what a function returns."""
    described = getattr(snapmap, name)
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
