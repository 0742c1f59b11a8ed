"""Writes docs/config.md from the schema and the code's defaults:

PYTHONPATH=workflow/scripts ./run python docs/make_config_reference.py
"""

import inspect
from dataclasses import replace
from pathlib import Path

import yaml

from snapmap import config, plan, quantity
from snapmap.beam.elements import hermite_elements
from snapmap.config.study import HANDOUT_CASE, load_device, load_study
from snapmap.device import Beam
from snapmap.solver.adaptive import build_ladder
from snapmap.solver.models import OPTIONS, build_model
from snapmap.solver.settings import THRESHOLD_TOLERANCE, Protocol
from snapmap.config.units import KINDS

HERE = Path(__file__).parent
SCHEMA = Path(config.__file__).with_name("schema.yaml")

EXAMPLE = """\
device:
  beam:
    span: 0.5 mm
    rise: 8 um
    thickness: 1.9 um
    depth: 20 um
    youngs_modulus: 160 GPa
    density: 2.33 g/cm^3
    damping: 4e-4 /us            # of the beam itself; left out: none
  mass: 6 ug
  spring: 4 N/m
  contact: hard
  gravity: 9.81 m/s^2

model:
  name: cosines
  modes: 4

sweep:
  N: {from: 200, to: 3000, points: 57}
  f0: {from: 0.2 kHz, to: 20 kHz, points: 25, spacing: log}
  C: [0.5 uN*us/um, 30 uN*us/um]
  horizon: 1 ms
  until: snap

histories:
  - {N: 1200, f0: 2 kHz, C: 0.5 uN*us/um}
"""

PAGE = """\
# The config, key by key

A config is a YAML file of one mapping. This page comes from the schema that every config is checked
against, `workflow/scripts/snapmap/schema.yaml`, and from the defaults in the code, by

    PYTHONPATH=workflow/scripts ./run python docs/make_config_reference.py

A physical value is text: a number and a unit, such as `600 um`. Any unit of the right kind will do
(`0.6 mm`), with powers, products and quotients (`kg/m^3`). Converted to µm, ng and µs, frequencies
to Hz, it must be from {least:g} to {most:g}, or 0 where 0 fits. Unknown keys are refused. What is
wrong is said before any job starts, in one line for each fault: the key, the value, and what would
be right.

{sections}

## Limits

Refused as a slip: more than {cells:,} cells; more than {dampings} values of C, as each gets a map;
and more than {hours:g} core hours, should every cell run to the horizon.

No value is evaluated or reaches a shell. But Snakemake itself, before it starts the workflow,
evaluates the expressions of a config file that says `__use_yte__: true`. Such a file is refused,
yet only after that: look for this line in a config that comes from somebody else.

## An example

Another device, with hard contact and some damping of the beam:

```yaml
{example}```
"""


def reference() -> str:
    """The text of docs/config.md."""
    load_study(yaml.safe_load(EXAMPLE))
    schema = yaml.safe_load(SCHEMA.read_text(encoding="utf-8"))
    return PAGE.format(
        least=quantity.LEAST,
        most=quantity.MOST,
        sections="\n\n".join(_sections(schema, code_defaults())),
        cells=plan.MOST_CELLS,
        dampings=plan.MOST_DAMPINGS,
        hours=plan.MOST_SECONDS / 3600,
        example=EXAMPLE,
    )


def _sections(schema, defaults):
    parts = schema["properties"]
    yield _section("", schema, defaults)
    yield _section("device", parts["device"], defaults)
    yield _section("device.beam", parts["device"]["properties"]["beam"], defaults)
    yield _section("model", parts["model"], defaults)
    yield _options()
    yield _section("sweep", parts["sweep"], defaults)
    yield _section("an axis given as a range", schema["$defs"]["axis"], defaults)
    yield _section("each of histories", _resolved(parts["histories"]["items"], schema), defaults)


def code_defaults() -> dict[str, str]:
    """What a key that is left out stands for, as text, by its name."""
    handout = load_device(HERE.parent / "config" / "config.yaml")
    elements = _arguments(hermite_elements)
    protocol = {key: f"`{value}`" for key, value in Protocol._field_defaults.items()}
    return {
        **{f"sweep.{key}": value for key, value in protocol.items()},
        "histories": f"N = {HANDOUT_CASE.N:g}, f0 = {HANDOUT_CASE.f0:g} Hz, "
        f"C = {HANDOUT_CASE.C:g} uN*us/um",
        "device.beam.damping": f"`{Beam.damping:g} /us`",
        "model.elements": f"`{elements['elements']}`",
        "model.mass_matrix": f"`{elements['mass_matrix']}`",
        "model.cosines": "as many as `modes`",
        "model.modes": _default_modes(handout),
        "model.step": _default_steps(handout),
        "model.tolerance": f"`{_arguments(build_ladder)['tolerance'] * 100:g} %`",
        "sweep.f0": "required, or `duration`",
        "sweep.duration": "`f0`",
        "each of histories.f0": "required, or `duration`",
        "each of histories.duration": "`f0`",
        "sweep.repeat": "`true` where `until` is `settled`",
        "sweep.threshold_tolerance": f"`{THRESHOLD_TOLERANCE:g}`",
        "an axis given as a range.spacing": "`linear`",
    }


def _arguments(function):
    return {key: given.default for key, given in inspect.signature(function).parameters.items()}


def _default_modes(device):
    kept = {name: build_model(device, name).modal.load.size for name in ("cosines", "elements")}
    hard = build_model(replace(device, contact=float("inf")), "elements").modal.load.size
    return (
        f"`{kept['cosines']}` cosines; of the elements all ({kept['elements']} of "
        f"{kept['elements']}), with hard contact three quarters ({hard} of {kept['elements']})"
    )


def _default_steps(device):
    hard = replace(device, contact=float("inf"))
    steps = [("cosines", device), ("elements", device), ("elements", hard)]
    cosines, elements, stiff = (
        build_model(one, name).dt / build_model(one, name, step=1).dt for name, one in steps
    )
    return (
        f"`{elements:g}` where all modes of the elements are kept, else `{cosines:g}`; with hard "
        f"contact `{stiff:g}`"
    )


def _section(name, section, defaults):
    rows = [
        f"| `{key}` | {_what(part)} | {_example(part)} | {_default(name, key, section, defaults)} |"
        for key, part in section["properties"].items()
    ]
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
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    if "format" in part:
        return KINDS[part["format"]].example.replace("'", "`").replace("1000", "`1000`")
    return ""


def _default(name, key, section, defaults):
    if key in section["required"]:
        return "required"
    return defaults[f"{name}.{key}".removeprefix(".")]


def _options():
    rows = [
        f"| `{name}` | {', '.join(f'`{key}`' for key in keys)} |" for name, keys in OPTIONS.items()
    ]
    return "\n".join(
        ["Each model has its own options:", "", "| name | options |", "|---|---|", *rows]
    )


def _resolved(section, schema):
    """The section with the shared part of each key's schema written out."""
    properties = {
        key: schema["$defs"][part["$ref"].rpartition("/")[2]] | part
        for key, part in section["properties"].items()
    }
    return section | {"properties": properties}


if __name__ == "__main__":
    (HERE / "config.md").write_text(reference(), encoding="utf-8")
