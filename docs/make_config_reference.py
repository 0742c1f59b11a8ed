"""Writes docs/config.md from the models of the config:

./run python docs/make_config_reference.py
"""

from inspect import cleandoc
from pathlib import Path

import yaml

from snapmap.applications import gather
from snapmap.config import devices, models, shocks, units
from snapmap.config.keys import Range
from snapmap.config.study import load_config
from snapmap.device.device import VALUES
from snapmap.solver.options import OPTIONS
from snapmap.sweeps import plan

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
  - {x: thickness, y: spring}                          # thresholds, in colours
  - {x: thickness, y: spring, at: {N: 1200}}           # outcomes
  - {x: thickness, y: N, at: {spring: 4 N/m}}          # outcomes, with the threshold as a line
"""

DEVICES = """\
devices:
  first: &first
    beam: {span: 500 um, rise: 8 um, thickness: 1.9 um, depth: 20 um, youngs_modulus: 160 GPa,
           density: 2330 kg/m^3}
    mass: 6 ug
    spring: 4 N/m
    contact: 60 N/m
    gravity: 9.81 m/s^2
  softer: {<<: *first, spring: 3 N/m}
"""

MODELS = {
    "elements": "Hermite elements on the half beam, as in the handout",
    "cosines": "symmetric cosines",
    "auto": "the cheapest sufficient number of cosines for each cell",
    "reference": "central differences of the handout in a plain loop; slow",
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
for sections in gather("described").values():
    SECTIONS |= sections

PAGE = """\
# The config, key by key

A config is a YAML file of one mapping, such as [the handout's](../config/handout.yaml),
[the same with damping](../config/damped.yaml) or [the tutorial's](../config/sensor.yaml). This page
comes from the models that read it, by

    ./run python docs/make_config_reference.py

A physical value is text: a number and any unit of its dimension, as in `2330 kg/m^3`. In µm, ng,
µs and Hz it must be from {least:g} to {most:g}, or 0 where 0 fits. Each mistake, also an unknown
key, is reported in one line before any job starts: the key, the value, and what would be right.
`snapmap check FILE` reports them without a run. Examples are in brackets; an axis is a list or a
[range](#an-axis-given-as-a-range). Axes and tolerances of the device keep `C` and `damping`, not
the `quality_factor` that replaces them.

{sections}

## Limits

Refused are more than {cells:,} cells; more than {dampings} values of C, as each gets a job; and
more than {hours:g} core hours, should every cell run to the horizon.

No value is evaluated or reaches a shell. But Snakemake evaluates the expressions of a config with
`__use_yte__: true` before it can be refused: look for this line in somebody else's config.

## Values of the device as axes

Values of the device under `sweep` are axes of all products, in the order of the config, followed by
`shape`, `direction`, C, f0 and N.

```yaml
{two_axes}```

A point whose beam has no second stable shape is refused; `not_bistable: skip` marks its cells
`absent` instead. Several devices, by name, are the first axis:

```yaml
{devices}```
"""

PLACES = "a list or a range {from, to, points, spacing}, each "
"""What the page says once, for all axes."""


def reference() -> str:
    """The text of docs/config.md."""
    document = yaml.safe_load(HANDOUT.read_text(encoding="utf-8"))
    load_config(document | yaml.safe_load(TWO_AXES))
    load_config({key: document[key] for key in ("model", "sweep")} | yaml.safe_load(DEVICES))
    return PAGE.format(
        least=units.LEAST,
        most=units.MOST,
        sections="\n\n".join(_sections()),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_SINGLE,
        hours=plan.MOST_SECONDS / 3600,
        two_axes=TWO_AXES,
        devices=DEVICES,
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
            row = keys[key].description.replace(PLACES, ""), shown["left_out"]
            if (key, *row) in before:
                again.append(key)
            else:
                rows.setdefault(row, {})[key] = shown["example"]
            before.add((key, *row))
        for (what, left_out), of in rows.items():
            examples = _listed(filter(None, dict.fromkeys(of.values())))
            what += f" ({examples})" * bool(examples)
            lines.append(_row(_listed(of), what, left_out))
        lines += [f"- {_listed(again)}: as above"] if again else []
        of_sweep = of_sweep or values
        if values:
            less = [key for key in of_sweep if key not in values]
            these = f"those of `sweep`{' but ' + _listed(less) if less else ''}"
            lines.append(_row(_listed(values) if values is of_sweep else these, *OF_VALUES[name]))
        yield "\n".join([*lines, *(_options() if name == "model" else [])])


def _row(keys, what, left_out):
    default = left_out if left_out.startswith("required") else f"default: {left_out}"
    return f"- {keys}: {what}; {default}"


def _listed(keys):
    return ", ".join(f"`{key}`" for key in keys)


def _options():
    rows = [f"| `{name}` | {MODELS[name]} | {_listed(keys)} |" for name, keys in OPTIONS.items()]
    head = ["", "Each model has its own options:", "", "| name | what | options |", "|---|---|---|"]
    return [*head, *rows]


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
