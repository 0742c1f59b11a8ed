"""Keys and values of version 0.3, as those of today."""

import copy
import json
from collections.abc import Mapping

from ..files.text import describe
from ..values.kinds import kind_of
from ..values.quantities import Share

OF_DEVICE = {
    "beam.clamp.axial": "beam.clamp_axial",
    "beam.guide": "beam.free",
    "stops.toward": "stop_toward",
    "stops.away": "stop_away",
    "stops.restitution": "restitution",
    "thermal.reference": "reference_temperature",
    "thermal.modulus": "modulus_slope",
    "thermal.mismatch": "expansion_mismatch",
    "thermal.damping": "damper_exponent",
    "strength.scale": "strength",
    "strength.modulus": "strength_modulus",
    "strength.threshold": "strength_threshold",
}
OF_RUN = ("horizon", "until", "repeat", "energy_tolerance", "start")
OF_SWEEP = {f"sweep.{key}": f"run.{key}" for key in OF_RUN} | {"sweep.not_bistable": "skip"}
VALUES = {
    ("beam.guide", "free"): True,
    ("beam.guide", "guided"): False,
    ("sweep.not_bistable", "skip"): True,
    ("sweep.not_bistable", "refuse"): False,
}
"""Values that are another word today."""


def renew(document: Mapping) -> tuple[dict, list[str]]:
    """Give a config with the keys of today, if it is one, and a line on each old key."""
    if not isinstance(document, Mapping):
        return document, []
    document = copy.deepcopy(dict(document))
    lines = _move(document, "", OF_SWEEP) + _move(document.get("device"), "device.", OF_DEVICE)
    devices = document.get("devices")
    for name in devices if isinstance(devices, dict) else ():
        devices[name] = copy.deepcopy(devices[name])  # which YAML's aliases may share
        lines += _move(devices[name], f"devices.{name}.", OF_DEVICE)
    return document, lines + _without_percent(document.get("model"))


def config_of(attributes: Mapping[str, str]) -> dict:
    """Give the config in the attributes of a dataset, with the keys of today; empty without one."""
    return renew(json.loads(attributes.get("config", "{}")))[0]


def _without_percent(model):
    """Convert the tolerance of a model from percent to the plain number of today."""
    text = model.get("tolerance") if isinstance(model, dict) else None
    if not isinstance(text, str) or not text.endswith("%"):
        return []
    try:
        model["tolerance"] = kind_of(Share).read(text)
    except ValueError:  # which is told beside all other faults
        return []
    words = f"{model['tolerance']:g} in place of {describe(text)}"
    return [f"model.tolerance: is a plain number since version 0.4; write {words}"]


def _move(section, path, names):
    """Move the values of a section from old keys to new ones, but to none that is there."""
    lines, old_homes = [], {old: _home(section, old) for old in names}
    for old, home in old_homes.items():
        key, new = old.rpartition(".")[2], names[old]
        new_home, last = _home(section, new, make=key in home), new.rpartition(".")[2]
        if key in home and new_home.get(last, home) is home:
            value = home.pop(key)
            known = isinstance(value, str) and (old, value) in VALUES
            new_home[last] = VALUES[old, value] if known else value
            word = f": {VALUES[old, value]}".lower() if known else ""
            lines.append(f"{path}{old}: is called {path}{new}{word} since version 0.4; write that")
    for old, home in old_homes.items():
        above, _, key = old.rpartition(".")[0].rpartition(".")
        outer = _home(section, f"{above}.{key}")
        if home == {} and key not in ("", "beam", "sweep") and outer.get(key) is home:
            del outer[key]
    return lines


def _home(section, path, make=False):
    """Give the mapping that has the last key of a path, or an empty one; make: make it, too."""
    for key in path.removeprefix(".").split(".")[:-1]:
        if not isinstance(section, dict):
            return {}
        section = section.setdefault(key, {}) if make else section.get(key)
    return section if isinstance(section, dict) else {}
