"""Writes docs/config.md from the models of the config:

./run python docs/make_config_reference.py
"""

from inspect import cleandoc
from pathlib import Path

import yaml

from snapmap.applications import gather
from snapmap.applications.requirements.sections import ShockSection
from snapmap.config import devices, models, shocks, units
from snapmap.config.keys import Range
from snapmap.config.study import load_config
from snapmap.device.device import VALUES
from snapmap.device.quantities import KINDS
from snapmap.solver.options import OPTIONS
from snapmap.workflow import plan

HERE = Path(__file__).parent
HANDOUT = HERE.parent / "config" / "handout.yaml"

TWO_AXES = """\
sweep:
  thickness: {from: 1.8 um, to: 2 um, points: 21}
  spring: {from: 3 N/m, to: 6 N/m, points: 21}
  duration: [1 ms]
  C: [25 uN*us/um]
  N: {from: 500, to: 2500, points: 41}
  horizon: 1 ms

maps:
  - {x: thickness, y: spring}                 # thresholds
  - {x: thickness, y: spring, at: {N: 1200}}  # outcomes
  - {x: thickness, y: N, at: {spring: 4 N/m}}  # both
"""

MODELS = {
    "elements": "Hermite elements on the half beam, as in the handout",
    "cosines": "symmetric cosines",
    "auto": "the cheapest sufficient number of cosines for each cell",
    "reference": "the handout's central differences in a plain loop; slow",
}

OF_VALUES = {
    "sweep": ("values (`[-5 MPa, 0 MPa, 5 MPa]`)", "the device's own"),
    "tolerances": (
        "a standard deviation, as a value or a share, or a mapping of its kind to its width "
        "(`0.05 um`, `5 %`, `{uniform: 0.2 um}`)",
        "no scatter",
    ),
    "calibration.unknowns": ("a pair of values: its range (`[1.7 um, 2.3 um]`)", "it is known"),
    "each of histories": ("a value (`1.9 um`)", "the device's own"),
}
"""What a section has for each value of the device: what, with an example; if left out."""
KIND = [*(kind.name for kind in KINDS.values()), "a whole number", "a number"]
LINKS = {
    "laws for `reference`": "[laws](own-physics.md#in-a-config) for `reference`",
    "three laws": "[three laws](applications/laws.md)",
}
SECTIONS = {
    "": models.Document,
    "device": devices.DeviceSection,
    "device.beam": devices.BeamSection,
    "device.beam.shape": devices.ShapeSection,
    "device.beam.clamp": devices.ClampSection,
    "device.stops": devices.StopsSection,
    "device.thermal": devices.ThermalSection,
    "device.strength": devices.StrengthSection,
    "model": models.ModelSection,
    "pulse": shocks.PulseSection,
    "each of pulse.train": shocks.Blow,
    "pulse.drop": shocks.Drop,
    "sweep": models.SweepSection,
    "an axis given as a range": Range,
    "each of maps": models.MapSection,
    "each of thresholds": models.LinesSection,
}
for sections in gather(lambda part: part.described()).values():
    SECTIONS |= sections

PAGE = """\
# The config, key by key

With this page you can look up every key of a config, with its unit, range and default. A config is
a YAML file of one mapping, such as [the handout's](../config/handout.yaml) or
[the tutorial's](../config/sensor.yaml).

A physical value is text: a number and any unit of its dimension, as in `2330 kg/m^3`. A number is
above 0 unless its line or example says otherwise; in µm, ng, µs and Hz it is from {least:g} to
{most:g}. `snapmap check FILE` names each mistake in one line. Examples are in brackets. An axis is
a list or a [range](#an-axis-given-as-a-range). Files are in the study's folder. Axes and tolerances
vary `C` and `damping`, not a `quality_factor`.

{sections}

## Limits

A study has at most {cells:,} cells, {dampings} values of C (each is a job) and {hours:g} core
hours, should every cell run to the horizon. No value is evaluated or reaches a shell. But Snakemake
evaluates a config with `__use_yte__: true` before snapmap can refuse it: look for it in a config
from others.

## Values of the device as axes

Values of the device under `sweep` are axes of all products, in the order of the config, followed by
`shape`, `direction`, C, f0 and N. Several devices, by name, are the first axis; in YAML,
`softer: {{<<: *first, spring: 3 N/m}}` repeats a device marked `&first` with another spring. A
point without a second stable shape is refused, or with `not_bistable: skip` marked `absent`.

```yaml
{two_axes}```
"""

SAID_ABOVE = (
    "a list or a range {from, to, points, spacing}, each ",
    " in the study's folder",
    " above 0",
    "a mapping: ",
    "the path of ",
    "true or false: ",
)
"""What the page says once, or shows."""


def reference() -> str:
    """The text of docs/config.md."""
    document = yaml.safe_load(HANDOUT.read_text(encoding="utf-8"))
    load_config(document | yaml.safe_load(TWO_AXES))
    return PAGE.format(
        least=units.LEAST,
        most=units.MOST,
        sections="\n\n".join(_sections()),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_SINGLE,
        hours=plan.MOST_SECONDS / 3600,
        two_axes=TWO_AXES,
    )


def _sections():
    """Tables of keys; a row for the device's values, those of an earlier section, those alike."""
    before, of_sweep = set(), []
    for name, section in SECTIONS.items():
        title = f"`{name}`" if name and " " not in name else name.capitalize() or "All sections"
        first, _, more = cleandoc(section.__doc__).partition("\n\n")
        lines = [f"## {title}", "", *([more, ""] if more else [first, ""] * ("`" not in title))]
        keys = {field.alias or key: field for key, field in section.model_fields.items()}
        values = [key for key in keys if key in VALUES] if name in OF_VALUES else []
        again, rows = [], {}
        for key in [key for key in keys if key not in values]:
            shown = keys[key].json_schema_extra
            row = _shorter(keys[key].description), shown["left_out"]
            if (key, *row) in before:
                again.append(key)
            else:
                rows.setdefault(row, {})[key] = shown["example"]
            before.add((key, *row))
        for (what, left_out), of in rows.items():
            examples = _listed(filter(None, dict.fromkeys(of.values())))
            what += f" ({examples})" * bool(examples)
            lines.append(_row(_listed(of), what, left_out))
        if again:
            shock = ShockSection.model_fields.keys() <= {*again}
            lines.append(f"- {'keys of other requirements' if shock else _listed(again)}: as above")
        of_sweep = of_sweep or values
        if values:
            less = [key for key in of_sweep if key not in values]
            these = f"those of `sweep`{' but ' + _listed(less) if less else ''}"
            lines.append(_row(_listed(values) if values is of_sweep else these, *OF_VALUES[name]))
        yield "\n".join([*lines, *(_options() if name == "model" else [])])


def _shorter(description):
    """What it is, with its bounds; the example shows the kind."""
    for words in SAID_ABOVE:
        description = description.replace(words, "")
    for words, link in LINKS.items():
        description = description.replace(words, link)
    need, _, what = description.partition(": ")
    kind = next((kind for kind in KIND if need.startswith(kind)), "")
    if not (kind and what):
        return description
    head, *more = what.split("; ")
    bounds = need.removeprefix(kind).removeprefix(" and").partition(",")[0].strip()
    return "; ".join([", ".join(filter(None, [head, bounds])), *more])


def _row(keys, what, left_out):
    default = left_out if left_out.startswith("required") else f"default: {left_out}"
    return f"- {keys}: {what}; {default}"


def _listed(keys):
    return ", ".join(f"`{key}`" for key in keys)


def _options():
    rows = [f"- `{name}`, with {_listed(keys)}: {MODELS[name]}" for name, keys in OPTIONS.items()]
    return ["", "Each name has its own options:", "", *rows]


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
