"""Writes docs/config.md from the schema and the code's defaults:

PYTHONPATH=workflow/scripts ./run python docs/make_config_reference.py
"""

import inspect
from dataclasses import replace
from pathlib import Path

import yaml

from snapmap.arguments import OPTIONS
from snapmap.beam.elements import hermite_elements
from snapmap.config import units
from snapmap.config.devices import load_device
from snapmap.config.histories import HANDOUT_CASE
from snapmap.config.schema import validator
from snapmap.config.shocks import OF_SPECTRA, SHARES, SURVIVES, WHOLE
from snapmap.config.study import load_config
from snapmap.config.views import MOST_MAPS
from snapmap.device import REFERENCE, RESTITUTION, VALUES, Beam, Device
from snapmap.pulse import TENTH, VERSED_SINE
from snapmap.quantities import KINDS, QUANTITIES
from snapmap.solver.adaptive import TOLERANCE
from snapmap.solver.models import build_model
from snapmap.solver.settings import MOVE, SNAP, STAY, THRESHOLD_TOLERANCE, Settings
from snapmap.solver.steps import OF_LIMIT
from snapmap.spectra.psd import REACH
from snapmap.sweeps import plan
from snapmap.tolerances.dataset import INDEX_SAMPLES
from snapmap.tolerances.samples import SHOCK_FACTORS, Tolerances

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
    "cosines": "symmetric cosines: [how exact each number is](accuracy.md#all-cases)",
    "auto": "for each cell the cheapest number of cosines that suffices",
    "reference": "the handout's scheme, central differences, as a plain loop: slow",
}

OF_VALUES = {
    "sweep": "a list or a range of values in place of the device's own, written as in `device` "
    "| `[-5 MPa, 0 MPa, 5 MPa]` | the device's own",
    "tolerances": "a standard deviation, as a value or a share, or a mapping of its kind (uniform: "
    "half the width; lognormal; truncated, at two standard deviations) to its width "
    "| `0.05 um`, `5 %`, `{uniform: 0.2 um}` | it does not scatter",
    "calibration.unknowns": "a pair of values, written as in `device`: where it is looked for "
    "| `[1.7 um, 2.3 um]` | it is known",
    "each of histories": "a value in place of the device's own, written as in `device` "
    "| `1.9 um` | the device's own",
}
"""What a section has for each value of the device: what, example, if left out."""

PAGE = """\
# The config, key by key

A config is a YAML file of one mapping, such as [the handout's](../config/config.yaml),
[the same with damping](../config/damped.yaml) or [the tutorial's](../config/sensor.yaml). This page
comes from the schema that every config is checked against,
`workflow/scripts/snapmap/config/schema.yaml`, and from the defaults in the code, by

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
    named = {key: document[key] for key in ("model", "sweep")} | yaml.safe_load(DEVICES)
    load_config(named)
    schema = validator().schema
    return PAGE.format(
        least=units.LEAST,
        most=units.MOST,
        sections="\n\n".join(_sections(schema, code_defaults())),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_SINGLE,
        hours=plan.MOST_SECONDS / 3600,
        two_axes=TWO_AXES,
        devices=DEVICES,
    )


def _sections(schema, defaults):
    parts = schema["properties"]
    yield _section("", schema, defaults)
    device = schema["$defs"]["device"]
    yield _section("device", device, defaults)
    yield _section("device.beam", device["properties"]["beam"], defaults)
    beam = device["properties"]["beam"]["properties"]
    yield _section("device.beam.shape", beam["shape"], defaults)
    yield _section("device.beam.clamp", beam["clamp"], defaults)
    yield _section("device.stops", device["properties"]["stops"], defaults)
    yield _section("device.thermal", device["properties"]["thermal"], defaults)
    yield _section("device.strength", device["properties"]["strength"], defaults)
    yield _section("model", parts["model"], defaults)
    yield _options()
    yield _section("pulse", _resolved(parts["pulse"], schema), defaults)
    kinds = schema["$defs"]
    yield _section("each of pulse.train", kinds["train"]["items"], defaults)
    yield _section("pulse.drop", kinds["drop"], defaults)
    yield _section("pulse.sweep", kinds["sine_sweep"], defaults)
    yield _section("sweep", parts["sweep"], defaults)
    yield _section("tolerances", parts["tolerances"], defaults)
    calibration = parts["calibration"]
    yield _section("calibration", calibration, defaults)
    yield _section("calibration.unknowns", calibration["properties"]["unknowns"], defaults)
    yield _section("an axis given as a range", schema["$defs"]["axis"], defaults)
    for key in ("requirements", "histories", "maps", "thresholds"):
        yield _section(f"each of {key}", _resolved(parts[key]["items"], schema), defaults)


def code_defaults() -> dict[str, str]:
    """What a key that is left out stands for, as text, by its name."""
    handout = load_device(HANDOUT)
    elements = _arguments(hermite_elements)
    settings = {key: f"`{value}`" for key, value in Settings().asked().items()}
    pushes = "pulse", "each of requirements"
    blows = *pushes, "each of pulse.train", "pulse.drop"
    history = "N = {N:g}, f0 = {f0:g} Hz, C = {C:g} uN*us/um".format(**HANDOUT_CASE)
    return {
        **{f"sweep.{key}": value for key, value in settings.items()},
        "each of histories.device": "the first",
        **_nominal("device.beam", Beam),
        **_nominal("device", Device),
        "device": "required, or `devices`",
        "devices": "`device`",
        "histories": f"the cell nearest to {history}",
        "marks": "none",
        "maps": f"N over f0 for each point of the other axes, {MOST_MAPS} of them at most",
        "thresholds": "over each axis of several values, lines for `device` or C",
        "each of maps.at": AT_LEFT_OUT,
        "each of thresholds.at": AT_LEFT_OUT,
        "sweep.not_bistable": "`refuse`",
        "device.beam.quality_factor": "`damping`",
        "device.quality_factor": "`sweep.C`",
        **dict.fromkeys(("device.spring", "device.contact"), "required, unless `mass` is none"),
        "device.gravity": "required, or `force`",
        "device.force": "the pulse shakes the frame",
        "sweep.C": "required, or `device.quality_factor`, or no mass",
        "device.stops": "the mass travels freely",
        **dict.fromkeys(("device.stops.toward", "device.stops.away"), "no stop on that side"),
        "device.stops.restitution": f"`{RESTITUTION:g}`",
        "device.thermal": "an axis temperature changes nothing",
        "device.thermal.reference": f"`{REFERENCE:g} degC`",
        **dict.fromkeys(
            (f"device.thermal.{key}" for key in ("modulus", "mismatch", "damping")), "`0`"
        ),
        "device.beam.shape": "`cosine`",
        **{f"device.beam.shape.{key}": "the other" for key in ("cosines", "file")},
        "device.beam.clamp": "rigid",
        "device.strength": "the beam never breaks",
        "device.strength.threshold": "`0 MPa`",
        "device.beam.guide": "`guided`",
        "device.beam.imperfection": "required if `guide` is `free`",
        "model.elements": f"`{elements['elements']}`",
        "model.mass_matrix": f"`{elements['mass_matrix']}`",
        "model.cosines": "as many as `modes`",
        "model.modes": _default_modes(handout),
        "model.step": _default_steps(handout),
        "model.tolerance": f"`{TOLERANCE * 100:g} %`",
        "pulse": "a versed sine along +z",
        "requirements": "none",
        "tolerances": "every device is as drawn",
        "calibration": "none",
        "calibration.C": "`sweep.C`, if it is one value; required else, unless it is unknown",
        "calibration.unknowns.C": "it is known",
        **{f"tolerances.{key}": "it does not scatter" for key in SHOCK_FACTORS},
        "tolerances.together": "each value by a draw of its own",
        "tolerances.samples": f"`{Tolerances._field_defaults['samples']}`",
        "tolerances.index_samples": f"`{INDEX_SAMPLES}`, or `samples` if these are fewer",
        "tolerances.seed": f"`{Tolerances._field_defaults['seed']}`",
        **{f"{where}.shape": f"`{VERSED_SINE}`" for where in blows},
        **{f"{where}.{key}": f"`{TENTH * 100:g} %`" for where in blows for key in SHARES},
        "each of pulse.train.N": "`1`",
        "each of pulse.train.duration": "`wait` or `repeat`, alone",
        "each of pulse.train.wait": "none",
        "each of pulse.train.repeat": "once",
        "pulse.drop.rebound": "`0`",
        **{f"{where}.{key}": "`shape`" for where in pushes for key in WHOLE},
        **{f"{where}.direction": "`+z`" for where in pushes},
        "each of requirements.f0": "required, or `duration`, `file`, `train`, `drop`, `sweep`, "
        "`psd`, `srs`",
        "each of requirements.N": "required, but of a drop or with `psd`, `srs`",
        **{f"each of requirements.{key}": "one shock" for key in OF_SPECTRA},
        "each of requirements.probability": f"`{100 * REACH:g} %`",
        "each of requirements.survives": f"`true`, which asks for `{SURVIVES * 100:g} %`",
        "each of requirements.duration": "`f0`",
        "sweep.f0": "required, or `duration`, or a pulse that has its own",
        "sweep.duration": "`f0`",
        "each of histories.f0": "required, or `duration`",
        "each of histories.duration": "`f0`",
        "sweep.repeat": "`true` where `until` is `settled`",
        "sweep.threshold_tolerance": f"`{THRESHOLD_TOLERANCE:g}`",
        "an axis given as a range.spacing": "`linear`",
    }


def _nominal(section, part):
    """What the values of a device are if its config is silent, by their keys."""
    return {
        f"{section}.{key}": f"`{getattr(part, key):g} {QUANTITIES[key].unit.removeprefix('1')}`"
        for key in VALUES
        if hasattr(part, key)
    }


def _arguments(function):
    return {key: given.default for key, given in inspect.signature(function).parameters.items()}


def _default_modes(device):
    kept = {name: build_model(device, name).modes for name in ("cosines", "elements")}
    hard = build_model(replace(device, contact=float("inf")), "elements").modes
    return (
        f"`{kept['cosines']}` cosines; of the elements all ({kept['elements']} of "
        f"{kept['elements']}), with hard contact three quarters ({hard} of {kept['elements']})"
    )


def _default_steps(device):
    longest = build_model(device, "cosines").steps.longest
    snap, stay, move = (f"{longest[question].item():.2g} us" for question in (SNAP, STAY, MOVE))
    return (
        f"of `reference` `{OF_LIMIT:g}`; elsewhere as the question, the pulse and the device "
        f"require: of slow pulses on the handout's device {snap} for whether it snaps, {stay} for "
        f"where it stays, {move} for how it moves"
    )


def _section(name, section, defaults):
    rows = [
        f"| `{key}` | {_what(part)} | {_example(part)} | {_default(name, key, section, defaults)} |"
        for key, part in section["properties"].items()
        if name not in OF_VALUES or key not in VALUES
    ]
    if name in OF_VALUES:
        rows.append(f"| {', '.join(f'`{key}`' for key in VALUES)} | {OF_VALUES[name]} |")
    head = ["| key | what | example | if left out |", "|---|---|---|---|"]
    title = f"## {_title(name)}"
    return "\n".join([title, "", f"{_sentence(section['description'])}", "", *head, *rows])


def _sentence(text):
    return f"{text[0].upper()}{text[1:]}."


def _title(name):
    return f"`{name}`" if name and " " not in name else name.capitalize() or "The whole"


def _what(part):
    return part["description"].replace("|", "\\|").replace("<=", "≤").replace(">=", "≥")


def _example(part):
    if "examples" in part:
        return ", ".join(f"`{value}`" for value in part["examples"])
    if len(part.get("enum", ())) > len(VALUES):
        return "any axis"
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if "format" in part:
        return KINDS[part["format"]].example.replace("'", "`").replace("1000", "`1000`")
    return ""


def _default(name, key, section, defaults):
    if key in section.get("required", ()):
        return "required"
    return defaults[f"{name}.{key}".removeprefix(".")]


def _options():
    rows = [
        f"| `{name}` | {MODELS[name]} | {', '.join(f'`{key}`' for key in keys)} |"
        for name, keys in OPTIONS.items()
    ]
    head = ["Each model has its own options:", "", "| name | what | options |", "|---|---|---|"]
    return "\n".join([*head, *rows])


AT_LEFT_OUT = "where the device itself stands; else in the middle, and for maps no N"


def _resolved(section, schema):
    """The section with the shared part of each key's schema written out."""
    properties = {
        key: schema["$defs"].get(part.get("$ref", "").rpartition("/")[2], {}) | part
        for key, part in section["properties"].items()
    }
    return section | {"properties": properties}


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
