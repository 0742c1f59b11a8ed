"""Lines on a study before it runs: how its devices vibrate, and what may be wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..beam.cosines import buckling_shapes
from ..beam.equilibria import find_barrier, second_shape, shapes_of
from ..beam.modal import natural_frequency
from ..device.device import Beam, Device
from ..files.text import plain
from ..solver.settings import FIRST
from .plausible import implausible, unusual_runs
from .points import read_points

if TYPE_CHECKING:
    from ..pulse.shocks import Shocks
    from .study import Config

IDLE = "has no effect; write device.modulus_slope, expansion_mismatch or damper_exponent"
HARDLY = 0.05
"""Barrier of the way back over that of the way there below which a device is hardly bistable."""
TILTING = 8
"""Number of shapes of each kind that decide whether a free beam has a second stable shape."""


def descriptions(study: Config) -> list[str]:
    """Describe each nominal device of a study, in one line each."""
    lines = list(study.measured.values())
    for name, device in study.devices().items():
        beam, words = device.beam, []
        for part, frequency, quality in vibrations(device, dampers(study)):
            words.append(f"{part} {frequency}, quality factor {quality}")
        if device.is_alone:
            words.append("no mass")
        if not beam.free and not beam.stays_if_free:
            words.append("assumed: the beam cannot tilt; if it can, write free: true")
        lines.append(
            f"{name}: rise/thickness {beam.rise / beam.thickness:.4g}, rise/span "
            f"{beam.rise / beam.span:.3g}, span/thickness {beam.span / beam.thickness:.4g}; "
            f"{'; '.join(words)}"
        )
    return lines


def dampers(study: Config) -> np.ndarray | None:
    """Give the values of C, uN us/um; None where a user's own laws decide its unit."""
    return None if study.model.laws else study.axes["C"]


def doubts_of_core(study: Config, records: Sequence[tuple[Shocks, float, str]] = ()) -> list[str]:
    """Warn, in lines, of values that are hardly meant and of what the model may leave out.

    records: recorded shocks beside the study's own, each with an f0, Hz, and a start
    """
    axes, (first, *_) = study.axes, study.devices().values()
    swings = max(pulse.swings for pulse in study.shocks.pulses)
    lines = implausible(study.grid.device, dampers(study), axes["f0"], swings)
    lines += unusual_runs(N=axes["N"], horizon=study.horizon)
    for name, device in study.devices().items():
        remarks = [barely(device), tilting(device.beam), stopped(device)]
        force = device.force
        if force:
            remarks.append(
                f"N counts multiples of {force:g} uN on the midpoint, also where a text says g"
            )
        slopes = device.modulus_slope, device.expansion_mismatch, device.damper_exponent
        if "temperature" in axes and not any(slopes):
            remarks.append(f"temperature: {IDLE}")
        lines += [f"{name}: {line}" for line in remarks if line]
    for shocks, f0, start in [(study.shocks, axes["f0"][-1], study.start), *records]:
        lines += shocks.doubts(is_pressed=start == FIRST)
        for pulse in shocks.shapes.values():
            lines += pulse.doubts(float(first.own_frequency), float(1e6 / f0), float(first.gravity))
    if study.own_points:
        lines += outside(study.own_points, axes)
    return lines


def barely(device: Device) -> str:
    """Warn, in one line or an empty one, of a device that nearly has no second stable shape."""
    beam, shapes = device.beam, shapes_of(device.beam)
    there = find_barrier(beam, shapes).energy
    back = there - float(second_shape(beam, shapes).energy)
    words = f"hardly bistable: the barrier of the way back is {back:.3g} pJ of {there:.3g} pJ there"
    return words if 0 < back < HARDLY * there else ""


def tilting(beam: Beam) -> str:
    """Warn, in one line or an empty one, of a beam that by tilting leaves its second shape."""
    if beam.free and find_barrier(beam, buckling_shapes(TILTING)).energy == 0:
        return (
            "beam free to tilt: no stable second shape, so nothing latches; a snap is the first "
            "arrival at the guided beam's second shape"
        )
    return ""


def stopped(device: Device) -> str:
    """Warn, in one line or an empty one, of a stop that leaves the mass too little room."""
    travel = device.stop_toward
    barrier = find_barrier(device.beam, shapes_of(device.beam))
    needed = float(device.gap - barrier.midpoint) if barrier.energy > 0 else 0.0
    if travel <= device.gap < np.inf:  # a beam alone is infinitely far from any mass
        return f"stop_toward: {travel:.4g} um is within the gap; the mass never meets the beam"
    if travel < needed:
        return (
            f"stop_toward: {travel:.4g} um stops the mass before the saddle at {needed:.4g} um: a "
            "slow shock does not snap the beam, and a fast one only by the beam's momentum"
        )
    return ""


def outside(own_points: tuple, axes: Mapping[str, np.ndarray]) -> list[str]:
    """Name, in a line each, a user's own points that lie on no map."""
    lines, path = [], own_points[0]
    for number, point in enumerate(read_points(*own_points), start=1):
        for key, value in (("f0", point.f0), ("N", point.N)):
            low, high = axes[key].min(), axes[key].max()
            if not low <= value <= high:
                name = f"{path}: {point.name or f'point {number}'}"
                place = f"{key} = {value:g}, maps from {low:g} to {high:g}"
                lines.append(f"{name} is outside every map: {place}")
    return lines


def vibrations(device: Device, C: Sequence[float] | None) -> list[list[str]]:
    """Give name, frequency and quality factor of the beam, and of the mass if the device has one.

    device: a single device; C: damping of the mass, uN us/um, None under a user's own laws
    """
    omega, damping = float(natural_frequency(device.beam)), float(device.beam.damping)
    rows = [["beam", _frequency(omega), _quality(omega, damping)]]
    if not device.is_alone:
        omega = float(device.mass_frequency)
        words = "not known under model.laws" if C is None else _damped(omega, float(device.mass), C)
        rows.append(["mass", _frequency(omega), words])
    return rows


def _damped(omega, mass, C):
    """Write the quality factor of the mass at the least and the largest C."""
    ends = dict.fromkeys((np.min(C), np.max(C)))
    rates = (f"{_quality(omega, end / mass)} at C = {plain(end)}" for end in ends)
    return f"{' to '.join(rates)} uN*us/um (critical: {plain(2 * mass * omega)})"


def _frequency(omega):
    return f"{plain(1e3 * omega / (2 * np.pi))} kHz"


def _quality(omega, rate):
    """Write the quality factor under a drag per mass of -rate v: omega/rate."""
    return f"{plain(omega / rate)}" if rate else "infinite"
