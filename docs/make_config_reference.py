"""Writes docs/config.md from the models of the config:

PYTHONPATH=workflow/scripts ./run python docs/make_config_reference.py
"""

from inspect import cleandoc
from pathlib import Path

import yaml

from snapmap.arguments import OPTIONS
from snapmap.config import calibration, devices, models, shocks, units
from snapmap.config.keys import Range
from snapmap.config.study import load_config
from snapmap.device import VALUES
from snapmap.sweeps import plan

HERE = Path(__file__).parent
HANDOUT = HERE.parent / "config" / "config.yaml"

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
    "handout": "Hermite elements on the half beam, all modes kept (hard contact: three quarters)",
    "elements": "the same, a few modes kept",
    "cosines": "symmetric cosines: [how exact each number is](accuracy.md#what-moves-a-threshold)",
    "auto": "for each cell the cheapest number of cosines that suffices",
    "reference": "the handout's scheme, central differences, as a plain loop: slow",
}

OF_VALUES = {
    "sweep": "a list or a range of values, written as in `device` | `[-5 MPa, 0 MPa, 5 MPa]` | the "
    "device's own",
    "tolerances": "a standard deviation, as a value or a share, or a mapping of its kind to its "
    "width | `0.05 um`, `5 %`, `{uniform: 0.2 um}` | it does not scatter",
    "calibration.unknowns": "a pair of values, written as in `device`: where it is looked for "
    "| `[1.7 um, 2.3 um]` | it is known",
    "each of histories": "a value, written as in `device` | `1.9 um` | the device's own",
}
"""What a section has for each value of the device: what, example, if left out."""
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
    "pulse.sweep": shocks.SineSweep,
    "sweep": models.SweepSection,
    "an axis given as a range": Range,
    "tolerances": models.TolerancesSection,
    "calibration": calibration.CalibrationSection,
    "calibration.unknowns": calibration.UnknownsSection,
    "each of requirements": shocks.RequirementSection,
    "each of histories": models.CellSection,
    "each of maps": models.MapSection,
    "each of thresholds": models.LinesSection,
}

PAGE = """\
# The config, key by key

A config is a YAML file of one mapping, such as [the handout's](../config/config.yaml),
[the same with damping](../config/damped.yaml) or [the tutorial's](../config/sensor.yaml). This page
comes from the models that every config is read by, `workflow/scripts/snapmap/config/models.py`, by

    PYTHONPATH=workflow/scripts ./run python docs/make_config_reference.py

A physical value is text: a number and a unit, such as `600 um`. Any unit of the right kind will do
(`0.6 mm`), with powers, products and quotients (`kg/m^3`). Converted to µm, ng and µs, frequencies
to Hz, it must be from {least:g} to {most:g}, or 0 where 0 fits. Unknown keys are refused. What is
wrong is said before any job starts, in one line for each fault: the key, the value, and what would
be right. `snapmap check FILE` says it without a run.

{sections}

## Limits

Refused as a slip: more than {cells:,} cells; more than {dampings} values of C, as each gets a job;
and more than {hours:g} core hours, should every cell run to the horizon.

No value is evaluated or reaches a shell. But Snakemake itself, before it starts the workflow,
evaluates the expressions of a config file that says `__use_yte__: true`. Such a file is refused,
yet only after that: look for this line in a config that comes from somebody else.

## Values of the device as axes

Any value of the device may stand under `sweep`, by its own key, and then takes the place of the
device's own. The axes of all products are these, in the order of the config, then `shape`,
`direction`, C, f0 and N.

```yaml
{two_axes}```

A point whose beam has no second stable shape is refused by name before any job starts, as it is a
slip more often than not. Where the limit itself is of interest, `not_bistable: skip` marks its
cells `absent` and goes on.

Several devices may be compared by their names, which then are the first axis; what they share is
written once:

```yaml
{devices}```
"""


def reference() -> str:
    """The text of docs/config.md."""
    document = yaml.safe_load(HANDOUT.read_text(encoding="utf-8"))
    load_config(document | yaml.safe_load(TWO_AXES))
    load_config({key: document[key] for key in ("model", "sweep")} | yaml.safe_load(DEVICES))
    return PAGE.format(
        least=units.LEAST,
        most=units.MOST,
        sections="\n\n".join(_section(*named) for named in SECTIONS.items()),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_SINGLE,
        hours=plan.MOST_SECONDS / 3600,
        two_axes=TWO_AXES,
        devices=DEVICES,
    )


def _section(name, section):
    """A table of keys; those of the device's values are one row, but where they are its own."""
    lines = [f"## {f'`{name}`' if name and ' ' not in name else name.capitalize() or 'The whole'}"]
    lines += ["", cleandoc(section.__doc__), ""]
    lines += ["| key | what | example | if left out |", "|---|---|---|---|"]
    keys = {field.alias or key: field for key, field in section.model_fields.items()}
    for key, field in keys.items():
        if name not in OF_VALUES or key not in VALUES:
            shown = field.json_schema_extra
            example = f"`{shown['example']}`" if shown["example"] else ""
            lines.append(f"| `{key}` | {field.description} | {example} | {shown['left_out']} |")
    if name in OF_VALUES:
        values = ", ".join(f"`{key}`" for key in keys if key in VALUES)
        lines.append(f"| {values} | {OF_VALUES[name]} |")
    return "\n".join([*lines, *(_options() if name == "model" else [])])


def _options():
    rows = [
        f"| `{name}` | {MODELS[name]} | {', '.join(f'`{key}`' for key in keys)} |"
        for name, keys in OPTIONS.items()
    ]
    head = ["", "Each model has its own options:", "", "| name | what | options |", "|---|---|---|"]
    return [*head, *rows]


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
