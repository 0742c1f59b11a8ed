"""Writes docs/config.md and config/schema.json from the records of the config:

./run python docs/make_config_reference.py
"""

import json
from collections.abc import Iterator
from inspect import getdoc
from itertools import groupby
from pathlib import Path

import yaml

from snapmap.applications.whole import Document, load_config
from snapmap.config.document import OF_SNAKEMAKE
from snapmap.device.device import VALUES
from snapmap.solver.options import MODELS
from snapmap.values.kinds import kind_of
from snapmap.values.records import Row, hints, rows
from snapmap.values.units import LEAST, MOST
from snapmap.workflow import plan

HERE = Path(__file__).parent
CONFIG = HERE.parent / "config"
DIALECT = "https://json-schema.org/draft/2020-12/schema"

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

Here you can look up every key of a config, with its unit, range and default
([glossary](tutorial.md#glossary)). A config is a YAML file of one mapping, such as
[the example's](../config/config.yaml) or [the tutorial's](../config/sensor.yaml). An editor with a
language server for YAML shows the same and marks mistakes, if the first line names
[the schema](../config/schema.json), as in those files; `snapmap init` writes both.

A physical value is text: a number and any unit of its dimension, as in `2330 kg/m^3`; in µm, ng, µs
and Hz it is from {least:g} to {most:g}. `snapmap check FILE` names each mistake in one line. Files
are in the study's folder. Axes and tolerances vary `C` and `damping`, not a `quality_factor`.

{sections}

## An axis given as a range

`{{from: 100 Hz, to: 30 kHz, points: 31, spacing: log}}` has both ends and is `linear` without
`spacing`. An axis is such a range or a list.

## Limits

A study has at most {cells:,} cells and {hours:g} core hours, should every cell run to the horizon.
snapmap runs no code from a config, but Snakemake does if the config
contains `__use_yte__: true`: look for this key in a config from others.

## Values of the device as axes

These values can stand under `sweep`: {values}.
They are axes of all results, in the order of the config, followed by `shape`, `direction`, C, f0
and N. Several devices, by name, are the first axis; in YAML,
`softer: {{<<: *first, spring: 3 N/m}}` repeats a device marked `&first` with another spring. A
point without a second stable shape is refused, or with `skip: true` marked `absent`.

```yaml
{two_axes}```
"""


AGAIN = " in the study's folder", " {from, to, points, spacing}"
"""What the page says of all files and ranges."""


def reference() -> str:
    """The text of docs/config.md."""
    document = yaml.safe_load((CONFIG / "handout.yaml").read_text(encoding="utf-8"))
    load_config(document | yaml.safe_load(TWO_AXES))
    return PAGE.format(
        least=LEAST,
        most=MOST,
        sections="\n\n".join(_sections("all sections", [Document], set(), {})),
        cells=plan.MOST_CELLS,
        hours=plan.MOST_SECONDS / 3600,
        values=", ".join(f"`{key}`" for key in VALUES),
        two_axes=TWO_AXES,
    )


def _sections(name: str, made: list[type], seen: set[type], said: dict) -> Iterator[str]:
    """Yield the section of a key, which is one of some records, and those of the keys in it.

    seen: records that the page has so far; said: the section that has a row; both are added to
    """
    seen |= {*made}
    yield f"## {_title(name)}"
    for one in made:
        text = getdoc(one).partition("\n\nParameters\n")[0]
        first, _, more = text.partition("\n\n")
        called = f"`name: {one.name}`: " if one in MODELS.values() else ""
        head = [f"### {called}{first.rstrip('.')}"] * bool(made[1:]) + [more] * bool(more)
        shown = {key for base in one.__mro__[1:] if base in made for key in hints(base)}
        left_out = {*shown, OF_SNAKEMAKE} | ({"name"} if called else set())
        listed = [row for row in rows(one) if row.key not in left_out]
        yield "\n\n".join([*head, "\n".join(_table(one, name, listed, said))])
        said |= dict.fromkeys(listed, name) | said
        if shown:
            yield "Other keys are those above."
    for key, hint in ((key, hint) for one in made for key, hint in hints(one).items()):
        if (nested := [*kind_of(hint).records]) and not seen.issuperset(nested):
            inner = f"{name}.{key}".removeprefix("all sections.")
            yield from _sections(
                f"each of {inner}" if "list[" in str(hint) else inner, nested, seen, said
            )


def _title(name: str) -> str:
    return name.capitalize() if " " in name else f"`{name}`"


def _table(made: type, name: str, listed: list[Row], said: dict[Row, str]) -> Iterator[str]:
    """Yield the lines of a table of keys; keys of which the same is said have one line."""
    yield "| Key | Meaning | Value | Default |"
    yield "|---|---|---|---|"
    new = [row for row in listed if row not in said]
    for (what, _), group in groupby(new, lambda row: (row.what, row.default)):
        row, *others = group
        kind = kind_of(hints(made)[row.key])
        value, example = "" if kind.records else row.need, getattr(kind, "example", "")
        if example.startswith("["):
            example = ""  # in the form of Python
        for words in AGAIN:
            value = value.replace(words, "")
        if example and kind.unit:  # which says what the kind is
            value = value.removeprefix(kind.noun).removeprefix(",").strip()
        if value and {row.need} != {other.need for other in (row, *others)}:
            value, example = "of its kind", ""
        value = ", ".join([value] * bool(value) + [f"`{example}`"] * bool(example))
        keys, default = [row.key, *(other.key for other in others)], _default(row)
        yield f"| {_listed(keys)} | {what} | {value} | {default} |"
    again = [row for row in listed if row in said]
    for place, group in groupby(again, said.get):
        where = "above" if place == name else f"in {place}" if " " in place else f"in `{place}`"
        yield f"| {_listed([row.key for row in group])} | as {where} | | |"


def _listed(keys: list[str]) -> str:
    """List keys; those of nearly all values of the device have a name."""
    less, more = [key for key in VALUES if key not in keys], [k for k in keys if k not in VALUES]
    if len(less) > 1:
        return ", ".join(f"`{key}`" for key in keys)
    but = "".join(f" but `{key}`" for key in less)
    of_device = f"each [value of the device](#values-of-the-device-as-axes){but}"
    return ", ".join([of_device, *(f"`{key}`" for key in more)])


def _default(row: Row) -> str:
    if row.required or row.default is None:
        return "required" if row.required else ""
    text = f"{row.default:g}" if isinstance(row.default, float) else str(row.default)
    return f"`{text.lower() if isinstance(row.default, bool) else text}`"


def written() -> str:
    """Write the schema by which editors complete and check a config, as JSON."""
    whole = kind_of(Document).schema()
    del whole["properties"]["run"]["properties"][OF_SNAKEMAKE]
    text = json.dumps({"$schema": DIALECT} | whole, indent=1, ensure_ascii=False)
    return f"{text}\n"


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
    (CONFIG / "schema.json").write_text(written(), encoding="utf-8")
