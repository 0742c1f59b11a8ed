"""The devices of a config."""

import warnings
from collections.abc import Mapping
from pathlib import Path

from ..beam.cosines import buckling_shapes
from ..beam.equilibria import find_barrier, least_travel
from ..curved_beam import COSINES
from ..device import ALONE, CLAMP, STOPS, STRENGTH, THERMAL, Beam, Device
from ..io.measured_shape import read_shape
from ..quantities import QUANTITIES
from ..shape import COSINE
from .faults import Faults, convert_part, refuse
from .quality import KEY, damped, damper
from .schema import name_of, schema_faults, validator
from .shocks import check_path
from .units import read, show
from .yaml_file import ConfigError, read_document

APART = "beam", "stops", "strength", "thermal", KEY
"""Keys of a device that are no value of it."""
AS_MEASURED = 0.1
"""By how much span and rise may differ from a measured shape's, relative."""
LEAST_TILT = 1e-6
"""Of a measured shape, um; below it there is none but rounding."""
TILTING = 8
"""Shapes of each kind by which it is told whether a free beam has a second one."""


def load_device(path: str | Path) -> Device:
    """Read the device of a config file, whatever its other sections; raises ConfigError.

    Its `quality_factor` stands for a C, which is no value of the device: a warning says which.

    >>> snapmap.load_device("config/config.yaml").beam.thickness
    2.0
    """
    document = read_document(path)
    if "device" not in document:
        raise ConfigError(f"device: missing; write {_wanted('device')}")
    faults = {at: line for at, line in schema_faults(document).items() if at[:1] == ("device",)}
    device = _convert_device(document, ("device",), faults)
    refuse(faults)
    lines = [*measured_shapes(document).values()]
    if KEY in document["device"]:
        C = damper(device, document["device"])
        lines.append(f"device.{KEY}: stands for C = {C:.6g} uN*us/um; give it to each call")
    for line in lines:
        warnings.warn(line, stacklevel=3)
    return device


def nominal(device: Device | Mapping[str, Device]) -> Device:
    """The device itself, or the first of several."""
    return next(iter(device.values())) if isinstance(device, Mapping) else device


def tilting(beam: Beam) -> str:
    """One line on what a beam that is guided, or free to tilt, means for its labels, or nothing."""
    if not beam.free and not beam.stays_if_free:
        ratio = beam.rise / beam.thickness
        return (
            f"rise/thickness = {ratio:.4g}: labels hold for a guided beam only; one free to tilt "
            "does not stay in the second shape"
        )
    if beam.free and find_barrier(beam, buckling_shapes(TILTING)).energy == 0:
        return (
            "free to tilt, the beam has no stable second shape: a snap is the midpoint's first "
            "arrival where a guided beam has its own, and nothing latches"
        )
    return ""


def stopped(device: Device) -> str:
    """One line on stops that leave the mass no room to snap the beam, or nothing."""
    if not device.has_stops:
        return ""
    way, needed = device.stop_toward, least_travel(device)
    if way <= device.gap:
        return f"stops.toward: {way:.4g} um is not beyond the gap; the mass never meets the beam"
    if way < needed:
        return (
            f"stops.toward: {way:.4g} um is short of the saddle, {needed:.4g} um from rest: a slow "
            "push does not snap the beam, and a fast one only by the speed that it gives the beam"
        )
    return ""


def pushed(device: Device) -> str:
    """One line on what N counts of a beam that is pushed at its midpoint, or nothing."""
    if not device.force:
        return ""
    return (
        f"N counts {device.force:g} uN of force on the midpoint, wherever multiples of g are named"
    )


def unwarmed(device: Device) -> str:
    """One line on a device of which a temperature changes nothing."""
    if device.modulus_slope or device.expansion_mismatch or device.damper_exponent:
        return ""
    return "temperature: changes nothing without device.thermal; write its coefficients there"


def read_devices(document: Mapping, faults: Faults) -> Device | dict[str, Device] | None:
    """Read the device of a study, or several by name; what is wrong joins `faults`.

    One of the two sections must be there.
    """
    both = "device" in document, "devices" in document
    if faults.get(()):
        return None
    if not any(both):
        faults[("device",)] = f"device: missing; write {_wanted('device')}"
    elif all(both):
        faults[("devices",)] = "devices: stand beside device; write one of them"
    elif both[0]:
        return _convert_device(document, ("device",), faults)
    elif not any(at[:1] == ("devices",) for at in faults):
        return {
            name: _convert_device(document, ("devices", name), faults, f"devices.{name}")
            for name in document["devices"]
        }
    return None


def _convert_device(document, path, faults, *name):
    """The device at a path; what is wrong joins `faults`, also beyond what the schema says."""
    section = document
    for key in path:
        section = section.get(key) if isinstance(section, Mapping) else None
    if isinstance(section, Mapping):
        for at, line in {**_of_the_mass(section), **_of_the_rise(section.get("beam"))}.items():
            whole = *path, *at
            faults.setdefault(whole, f"{name_of(whole)}: {line}")
    return convert_part(document, path, faults, read_device, *name)


def _of_the_rise(beam):
    """Name a rise of 0 if nothing buckles the beam."""
    if not (isinstance(beam, Mapping) and _is_loose(beam)):
        return {}
    straight = f"{show(beam['rise'])} is of a straight beam, which only compression buckles"
    return {("beam", "rise"): f"{straight}; write a rise > 0, or a residual_stress < 0"}


def _is_loose(beam):
    """Whether it is straight, and nothing presses it."""
    try:
        pressed = read(beam.get("residual_stress", "0 MPa"), "stress") < 0
        return read(beam.get("rise"), "distance") == 0 and not pressed
    except ValueError:  # a fault with a line of its own
        return False


def _wanted(key):
    return validator().schema["properties"][key]["description"]


def read_device(section: Mapping, name: str = "device") -> Device:
    """Read a section that describes a device; raises ValueError, one line, with its name."""
    formats = validator().schema["$defs"]["device"]["properties"]
    try:
        return Device(
            beam=_beam(section["beam"], formats["beam"]["properties"]),
            **_struck(section, formats),
            **_values(section.get("stops", {}), STOPS),
            **_strength(section.get("strength", {})),
            **_thermal(section.get("thermal", {})),
        )
    except ValueError as error:
        raise ValueError(str(error).replace("device.", f"{name}.", 1)) from None


def _struck(section, formats):
    """Values of the mass and the pulse, or of a beam alone under either."""
    values = {key: section[key] for key in section if key not in APART}
    own = ALONE if values["mass"] == "none" else {}
    return {"gravity": 1.0} | _convert(values, formats) | own


def _of_the_mass(section):
    """Name what a device lacks, or has too much of, with a mass and without one."""
    alone, pushed = section.get("mass") == "none", "force" in section
    needed = [*([] if alone else ["spring", "contact"]), *([] if pushed else ["gravity"])]
    formats = validator().schema["$defs"]["device"]["properties"]
    said = {key: f"missing; write {formats[key]['description']}" for key in needed}
    said = {key: line for key, line in said.items() if key not in section}
    if alone:
        extra = [key for key in (*ALONE, "stops", KEY) if key in section and key != "mass"]
        said |= dict.fromkeys(extra, "is of the mass, and there is none; leave it out")
    if pushed and "gravity" in section:
        said["gravity"] = "stands beside force; N counts multiples of one of them"
    return {(key,): line for key, line in said.items()}


def _beam(section, formats):
    apart = "guide", "shape", "clamp", KEY
    values = {key: value for key, value in section.items() if key not in apart}
    free = section.get("guide") == "free"
    if "imperfection" in section and not free:
        raise ValueError("device.beam.imperfection: is of a free beam; write guide: free")
    given = _convert(values, formats) | _values(section.get("clamp", {}), CLAMP)
    given |= _shape(section.get("shape", COSINE), given, free)
    beam = Beam(**given, free=float(free))
    if KEY not in section:
        return beam
    if "damping" in section:
        raise ValueError(f"device.beam.{KEY}: stands beside damping; write one of them")
    return damped(beam, read(section[KEY], "quality"))


def _shape(given, others, free):
    """The values of a beam that its shape sets; others: those given themselves."""
    if isinstance(given, str):
        return {"shape": given}
    tilt = {}
    if "file" in given:
        check_path(given["file"])
        measured = read_shape(given["file"])
        terms = measured.cosines
        for key, found in (("span", measured.length), ("rise", measured.rise)):
            if not abs(found / others[key] - 1) < AS_MEASURED:
                told = f"{others[key]:g} um, where {given['file']} has {found:.4g} um"
                raise ValueError(f"device.beam.{key}: {told}; is a unit wrong?")
        if free and "imperfection" not in others and measured.tilt > LEAST_TILT:
            tilt = {"imperfection": measured.tilt}
    else:
        terms = given["cosines"]
    if beside := next((name for name in COSINES if name in others), None):
        raise ValueError(f"device.beam.{beside}: stands beside the cosines of shape; write one")
    rise = sum(terms[::2])
    if not rise > 0:
        raise ValueError(f"device.beam.shape.cosines: the odd ones add up to {rise:g}; write more")
    return tilt | dict(zip(COSINES, (term / rise for term in terms[1:]), strict=False))


def measured_shapes(document: Mapping) -> dict[tuple[str, str], str]:
    """Lines on shapes read from files, by device and path: how far from them the fit is."""
    named = document.get("devices") or {"device": document.get("device")}
    lines = {}
    for name, section in named.items():
        given = section["beam"].get("shape")
        if isinstance(given, Mapping) and "file" in given:
            path = given["file"]
            lines[name, path] = f"{name}, {path}: {read_shape(path).words}"
    return lines


def _strength(given):
    try:
        return _values(given if isinstance(given, Mapping) else {"scale": given}, STRENGTH)
    except ValueError as error:
        raise ValueError(f"device.strength: {error}") from None


def _values(section, names):
    named = {names[key]: value for key, value in section.items()}
    return {key: read(value, QUANTITIES[key].kind) for key, value in named.items()}


def _thermal(section):
    """The device is at the reference: its temperature is an axis."""
    values = _values(section, THERMAL)
    at = "reference_temperature"
    return values | {"temperature": values[at]} if at in values else values


def _convert(section, formats):
    return {key: read(value, formats[key]["format"]) for key, value in section.items()}
