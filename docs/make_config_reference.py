"""Writes docs/config.md and config/schema.json from the records of the config:

./run python docs/make_config_reference.py
"""

from collections.abc import Iterator
from dataclasses import is_dataclass
from inspect import getdoc
from itertools import groupby
from pathlib import Path
from typing import get_args

import yaml

from snapmap.config.document import OF_SNAKEMAKE, Document
from snapmap.config.schema import written
from snapmap.config.study import load_config
from snapmap.device.device import VALUES
from snapmap.values.fields import hints, rows
from snapmap.values.kinds import kind_of
from snapmap.values.units import LEAST, MOST
from snapmap.workflow import plan

HERE = Path(__file__).parent
CONFIG = HERE.parent / "config"

TWO_AXES = """\
sweep:
  thickness: {from: 1.8 um, to: 2 um, points: 21}
  spring: {from: 3 N/m, to: 6 N/m, points: 21}
  duration: [1 ms]
  C: [25 uN*us/um]
  N: {from: 500, to: 2500, points: 41}

maps:
  - {x: thickness, y: spring}                 # thresholds
  - {x: thickness, y: spring, at: {N: 1200}}  # outcomes
  - {x: thickness, y: N, at: {spring: 4 N/m}}  # both
"""

PAGE = """\
# The config, key by key

With this page you can look up every key of a config, with its unit, range and default. A config is
a YAML file of one mapping, such as [the handout's](../config/handout.yaml) or
[the tutorial's](../config/sensor.yaml). An editor with a language server for YAML shows the same
and marks mistakes, if the first line names [the schema](../config/schema.json), as in those files;
`snapmap init` writes both.

A physical value is text: a number and any unit of its dimension, as in `2330 kg/m^3`; in µm, ng, µs
and Hz it is from {least:g} to {most:g}. `snapmap check FILE` names each mistake in one line. Files
are in the study's folder. Axes and tolerances vary `C` and `damping`, not a `quality_factor`.

{sections}

## An axis given as a range

`{{from: 100 Hz, to: 30 kHz, points: 31, spacing: log}}` has both ends and is `linear` without
`spacing`. An axis is such a range or a list.

## Limits

A study has at most {cells:,} cells, {dampings} values of C (each is a job) and {hours:g} core
hours, should every cell run to the horizon. No value is evaluated or reaches a shell. But Snakemake
evaluates a config with `__use_yte__: true` before snapmap can refuse it: look for it in a config
from others.

## Values of the device as axes

Values of the device under `sweep` are axes of all products, in the order of the config, followed by
`shape`, `direction`, C, f0 and N. They are {values}.
Several devices, by name, are the first axis; in YAML,
`softer: {{<<: *first, spring: 3 N/m}}` repeats a device marked `&first` with another spring. A
point without a second stable shape is refused, or with `skip: true` marked `absent`.

```yaml
{two_axes}```
"""


def reference() -> str:
    """The text of docs/config.md."""
    document = yaml.safe_load((CONFIG / "handout.yaml").read_text(encoding="utf-8"))
    load_config(document | yaml.safe_load(TWO_AXES))
    return PAGE.format(
        least=LEAST,
        most=MOST,
        sections="\n\n".join(_sections("all sections", [Document], set())),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_SINGLE,
        hours=plan.MOST_SECONDS / 3600,
        values=", ".join(f"`{key}`" for key in VALUES),
        two_axes=TWO_AXES,
    )


def _sections(name: str, made: list[type], seen: set[type]) -> Iterator[str]:
    """Yield the section of a key, which is one of some records, and those of the keys in it."""
    seen |= {*made}
    yield f"## {_title(name)}"
    for one in made:
        text = getdoc(one).partition("\n\nParameters\n")[0]
        first, _, more = text.partition("\n\n")
        head = [f"### {first.rstrip('.')}"] + [more] * bool(more) if made[1:] else [text]
        shown = {key for base in one.__mro__[1:] if base in made for key in hints(base)}
        yield "\n\n".join([*head, "\n".join(_table(one, {*shown, OF_SNAKEMAKE}))])
        if shown:
            yield "Other keys are those above."
    for key, hint in ((key, hint) for one in made for key, hint in hints(one).items()):
        if (nested := _records(hint)) and not seen.issuperset(nested):
            inner = f"{name}.{key}".removeprefix("all sections.")
            yield from _sections(
                f"each of {inner}" if "list[" in str(hint) else inner, nested, seen
            )


def _title(name: str) -> str:
    return name.capitalize() if " " in name else f"`{name}`"


def _records(hint: object) -> list[type]:
    """Find the records in an annotation."""
    if is_dataclass(hint):
        return [hint]
    kind = kind_of(hint)
    return [*kind.records] if kind else [one for part in get_args(hint) for one in _records(part)]


def _table(made: type, left_out: set[str]) -> Iterator[str]:
    """Yield the lines of a table of keys; keys of which the same is said have one line."""
    yield "| Key | Meaning | Value | Default |"
    yield "|---|---|---|---|"
    shown = [row for row in rows(made) if row.key not in left_out]
    for (what, _), group in groupby(shown, lambda row: (row.what, row.default)):
        row, *others = group
        keys, hint = [row.key, *(other.key for other in others)], hints(made)[row.key]
        value, example = "" if _records(hint) else row.need, getattr(kind_of(hint), "example", "")
        if others and value:
            value, example = "of its kind", ""
        value += f", `{example}`" * bool(example)
        needed = row.required or get_args(hint) == (row.default,)
        yield f"| {_listed(keys)} | {what} | {value} | {_default(row.default, needed)} |"


def _listed(keys: list[str]) -> str:
    """List keys; those of nearly all values of the device have a name."""
    less, more = [key for key in VALUES if key not in keys], [k for k in keys if k not in VALUES]
    if len(less) > 1:
        return ", ".join(f"`{key}`" for key in keys)
    but = "".join(f" but `{key}`" for key in less)
    of_device = f"each [value of the device](#values-of-the-device-as-axes){but}"
    return ", ".join([of_device, *(f"`{key}`" for key in more)])


def _default(default: object, needed: bool) -> str:
    if needed or default is None:
        return "required" if needed else ""
    text = f"{default:g}" if isinstance(default, float) else str(default)
    return f"`{text.lower() if isinstance(default, bool) else text}`"


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
    (CONFIG / "schema.json").write_text(written(), encoding="utf-8")
