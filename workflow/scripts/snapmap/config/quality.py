"""Quality factors of a config, in place of the damping of beam and mass."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..beam.modal import natural_frequency
from ..device import Beam, Device
from .faults import Faults
from .schema import name_of
from .units import read

KEY = "quality_factor"


def damped(beam: Beam, quality_factor: float) -> Beam:
    """The beam with the damping that gives its first symmetric mode a quality factor."""
    # ASSUME: a measured one is that mode's, of the beam clear of the mass; the drag is that of all
    # modes, so that others have quality factors in proportion to their frequencies.
    return replace(beam, damping=natural_frequency(beam) / quality_factor)


def damper_of(
    document: Mapping, device: Device | Mapping[str, Device] | None, faults: Faults
) -> float | None:
    """C of the mass, uN us/um, if the sweep leaves it to the quality factor of the device.

    device: as the document has it; what is wrong joins `faults`
    """
    sweep, several = document.get("sweep"), "devices" in document
    sections = document["devices"] if several else {"": document.get("device")}
    if not isinstance(sweep, Mapping) or not isinstance(sections, Mapping):
        return None
    masses = [one.get("mass") if isinstance(one, Mapping) else None for one in sections.values()]
    if masses and all(mass == "none" for mass in masses):
        if "C" in sweep:
            faults[("sweep", "C")] = "sweep.C: is of the mass, and there is none; leave it out"
        return 0.0
    given = [name for name, one in sections.items() if isinstance(one, Mapping) and KEY in one]
    if "C" in sweep:
        for name in given:
            at = ("devices", name, KEY) if several else ("device", KEY)
            faults[at] = f"{name_of(at)}: stands beside sweep.C; write one of them"
    elif not given:
        wanted = "dampers (force time per length) of the mass, or device.quality_factor"
        faults[("sweep", "C")] = f"sweep.C: missing; write {wanted}"
    elif device is not None:
        named = device if isinstance(device, Mapping) else {"": device}
        found = {damper(named[name], sections[name]) for name in sections}
        if len(found) == 1:
            return found.pop()
        complaint = "quality factors give no C that all devices share; write sweep.C"
        faults[("devices",)] = f"devices: {complaint}"
    return None


def damper(device: Device, section: Mapping) -> float | None:
    """C of a device and its section, uN us/um; None without a quality factor."""
    root = np.sqrt(device.spring * device.mass)
    return float(root / read(section[KEY], "quality")) if KEY in section else None
