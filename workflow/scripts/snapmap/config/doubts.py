"""Lines on what is hardly meant, as a wrong unit leaves behind, and on what a device leaves out."""

import math
from collections.abc import Mapping

import numpy as np

from ..beam.cosines import buckling_shapes
from ..beam.equilibria import find_barrier, least_travel
from ..described import describe, excited
from ..device import VALUES, Beam, Device
from ..io.tables import read_points
from ..quantities import QUANTITIES
from ..study import Study
from ..tolerances.samples import Plan

STEEP = 0.05
"""Rise over span above which what is neglected raises forces by more than 1 %."""
FORCES_TOO_HIGH, THRESHOLDS_TOO_HIGH = 565.0, 413.0
"""By how much, in %, over the square of rise over span: docs/peers.md."""
SLENDER = 20.0, 5000.0
"""Span over thickness below which the same holds of shear; above no beam is made."""
CREEPING = 10.0
"""C over that of critical damping."""
WIDE = 0.3
"""Scatter over the nominal value."""
FAR = 1000.0
"""Duration of a pulse over a period, or the reverse."""
TILTING = 8
"""Shapes of each kind by which it is told whether a free beam has a second one."""


def descriptions(study: Study) -> list[str]:
    """Lines on each device, whatever the axes change, and on how a record excites it.

    study: a `Config`
    """
    C, lines = study.axes["C"], list(study.measured.values())
    records = [one for one in study.shocks.shapes.values() if one.duration and not one.blows.size]
    for name, one in study.devices().items():
        beam = one.beam
        lines.append(
            f"{name}: rise/thickness {beam.rise / beam.thickness:.4g}, rise/span "
            f"{beam.rise / beam.span:.3g}, span/thickness {beam.span / beam.thickness:.4g}; "
            f"{describe(one, C)}"
        )
        lines += [f"{name}, {pulse.name}: {excited(one, pulse)}" for pulse in records]
    return lines


def doubts(study: Study) -> list[str]:
    """Lines on what is hardly meant, and on what devices and recorded shocks may leave out.

    study: a `Config`
    """
    axes, scatter, (first, *_) = study.axes, study.tolerances, study.devices().values()
    lines = implausible(study.grid.device, axes["C"], axes["f0"])
    for name, one in study.devices().items():
        own = [tilting(one.beam), stopped(one)]
        if one.force:
            own += [
                f"N counts {one.force:g} uN of force on the midpoint, wherever multiples of g are "
                "named"
            ]
        slopes = one.modulus_slope, one.expansion_mismatch, one.damper_exponent
        if "temperature" in axes and not any(slopes):
            own += ["temperature: changes nothing without device.thermal; write its values there"]
        lines += [f"{name}: {line}" for line in own if line]
    slowest, shortest = first.own_frequency, 1e6 / axes["f0"][-1]
    for pulse in study.shocks.shapes.values():
        lines += pulse.doubts(float(slowest), float(shortest))
    if study.own_points:
        lines += outside(study.own_points[0], axes)
    for one in study.devices().values() if scatter else ():
        lines += wide(Plan(one, scatter.scatters, scatter.together))
    return lines


def unusual(device: Device) -> list[str]:
    """Lines on values beyond what is usual, of a batch of devices."""
    lines = []
    for key in VALUES:
        low, high = QUANTITIES[key].usual
        values = np.atleast_1d(getattr(device.beam if hasattr(device.beam, key) else device, key))
        beyond = values[(values < low) | (values > high)]
        if beyond.size:
            unit = QUANTITIES[key].unit
            lines.append(
                f"{key} = {beyond[0]:.4g} {unit} is not from {low:g} to {high:g}, as is usual; is "
                "its unit right?"
            )
    return lines


def wide(plan: Plan) -> list[str]:
    """Lines on values that scatter by more than is made."""
    lines = []
    for key, scatter in plan.scatters.items():
        share = scatter.width / (1.0 if scatter.is_share else abs(plan.nominal[key]) or math.inf)
        if share > WIDE:
            lines.append(f"{key} scatters by {100 * share:.3g} %: hardly meant above {WIDE:.0%}")
    return lines


def implausible(device: Device, C: np.ndarray, f0: np.ndarray) -> list[str]:
    """Lines on what is hardly meant, of a batch of devices; C: uN us/um, f0: Hz, ascending."""
    beam, own = device.beam, device.own_frequency
    mass = np.where(device.is_alone, own, device.mass_frequency)
    steepest = np.max(beam.rise / beam.span)
    slender = beam.span / beam.thickness
    critical = np.min(2 * device.mass * mass)
    damped = C[-1] / critical if critical else 0.0
    lasts = f0 * (2e-6 * np.pi)
    first, last = np.min(own), np.max(np.maximum(mass, beam.bending_frequency))
    lines = {
        f"rise/span = {steepest:.3g}: above {STEEP:g} the beam is no shallow arch; forces come out "
        f"{FORCES_TOO_HIGH * steepest**2:.2g} % too high, thresholds "
        f"{THRESHOLDS_TOO_HIGH * steepest**2:.2g} %": steepest > STEEP,
        f"span/thickness = {slender.min():.3g}: below {SLENDER[0]:g} shear counts, which the model "
        "leaves out": slender.min() < SLENDER[0],
        f"span/thickness = {slender.max():.3g}: no beam is made above {SLENDER[1]:g}; is a unit "
        "wrong?": slender.max() > SLENDER[1],
        f"C = {C[-1]:.4g} uN*us/um is {damped:.3g} times that of critical damping; is its unit "
        "right?": damped > CREEPING,
        f"f0 up to {f0[-1]:.4g} Hz: all pulses last over {FAR:g} periods of beam and mass; they "
        "act as a lasting acceleration": lasts[-1] * FAR < first,
        f"f0 from {f0[0]:.4g} Hz: all pulses are over in a {FAR:g}th of any period; they act as a "
        "jump in velocity": lasts[0] > FAR * last,
    }
    return unusual(device) + [line for line, holds in lines.items() if holds]


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
    travel, needed = device.stop_toward, least_travel(device)
    if travel <= device.gap:
        return f"stops.toward: {travel:.4g} um is not beyond the gap; the mass never meets the beam"
    if travel < needed:
        return (
            f"stops.toward: {travel:.4g} um is short of the saddle, {needed:.4g} um from rest: a "
            "slow push does not snap the beam, a fast one only by the speed that it gives the beam"
        )
    return ""


def outside(path: str, axes: Mapping[str, np.ndarray]) -> list[str]:
    """A line for each of a user's own points that lies on no map."""
    lines = []
    for number, point in enumerate(read_points(path), start=1):
        for key, value in (("f0", point.f0), ("N", point.N)):
            low, high = axes[key].min(), axes[key].max()
            if not low <= value <= high:
                place = f"{key} = {value:g}, maps from {low:g} to {high:g}"
                who = f"{path}: {point.name or f'point {number}'}"
                lines.append(f"{who} lies on no map: {place}")
    return lines
