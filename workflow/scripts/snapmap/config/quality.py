"""Quality factors of a config, in place of the damping of beam and mass, and what rings."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..beam.vibration import natural_frequency
from ..device import Beam, Device
from ..pulse import Pulse
from ..shock_spectra.spectrum import pulse_response
from ..solver.cells import check_cells
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
        found = {_damper(named[name], sections[name]) for name in sections}
        if len(found) == 1:
            return found.pop()
        complaint = "quality factors give no C that all devices share; write sweep.C"
        faults[("devices",)] = f"devices: {complaint}"
    return None


def _damper(device, section):
    """C, or None without a quality factor."""
    root = np.sqrt(device.spring * device.mass)
    return float(root / read(section[KEY], "quality")) if KEY in section else None


def describe(device: Device, C: Sequence[float] = ()) -> str:
    """One line on how beam and mass vibrate, each by itself: frequencies and quality factors.

    device: a single one; C: of the mass, uN us/um, from 0; a ValueError names one that cannot be

    >>> snapmap.describe(snapmap.load_device("config/damped.yaml"))
    'beam 157.8 kHz, quality factor 247.8; mass 3.733 kHz'
    """
    own = _own(device)
    beam, mass = (f"{1e3 * omega / (2 * np.pi):.4g} kHz" for omega in own)
    words = f"beam {beam}, quality factor {_quality(own[0], device.beam.damping)}; "
    words += "no mass" if device.is_alone else f"mass {mass}"
    if device.is_alone or not np.size(C):
        return words
    check_cells(C=C)
    ends = dict.fromkeys((np.min(C), np.max(C)))
    rates = (f"{_quality(own[1], one / device.mass)} at C = {one:.4g}" for one in ends)
    critical = 2 * device.mass * own[1]
    return f"{words}, quality factor {' to '.join(rates)} uN*us/um (critical: {critical:.4g})"


def excited(device: Device, pulse: Pulse) -> str:
    """One line on the shock response spectrum of a pulse at the device's own frequencies."""
    own = _own(device)[: 1 if device.is_alone else 2]
    found = pulse_response(pulse, pulse.duration, np.array(own) / (2e-6 * np.pi))
    told = [f"{one:.3g} at the {of}'s" for one, of in zip(found, ("beam", "mass"), strict=False)]
    told[-1] += " frequency"
    return f"shock response (quality factor 10) over its peak {', '.join(told[::-1])}"


def _own(device):
    """Frequencies of beam and mass, rad/us."""
    return natural_frequency(device.beam), float(device.mass_frequency)


def _quality(omega, rate):
    """Of a swing whose drag per mass is -rate v: a radian takes rate/omega of its energy."""
    return f"{omega / rate:.4g}" if rate else "infinite"
