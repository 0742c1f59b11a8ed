"""Warnings of values that are hardly meant, as after a slip of a unit."""

import math

import numpy as np

from ..device.device import ALONE, KINDS, Device, is_bistable
from ..device.samples import SHOCK_FACTORS, Plan
from ..device.usual import USUAL
from ..files.text import plain
from ..values.units import used

STEEP = 0.05
"""Rise over span above which the assumption of a shallow arch raises forces by more than 1 %."""
FORCES_TOO_HIGH, THRESHOLDS_TOO_HIGH = 565.0, 538.0
"""Errors of forces and of slow shocks' thresholds in %, over the square of rise over span:
docs/validation.md."""
SLENDER = 20.0, 5000.0
"""Span over thickness below which shear raises forces by 1 %, and above which no beam is made."""
SLAB = 0.05, 10.0
"""Depth over thickness below which, and over span above which, no beam is made."""
CREEPING = 10.0
"""C over critical damping above which it is hardly meant."""
WIDE = 0.3
"""Scatter over the nominal value above which it is hardly meant."""
OF_RUNS = {"N": (0.0, 1e6, ""), "horizon": (1.0, 1e7, "us")}
"""Usual ranges, and units, of values that are not of a device."""
OUTSIDE = "{} = {} is outside the usual {} to {}; is its unit right?"
FAR = 1000.0
"""Duration of a pulse over a period, or the reverse, above which it is hardly meant."""


def unusual(device: Device) -> list[str]:
    """Warn, in lines, of values of a batch of devices that are beyond the usual."""
    lines = []
    for key, (low, high) in USUAL.items():
        unit = KINDS[key].unit
        reads = "kg" if unit == "ng" else KINDS[key].reads  # what is far too heavy is in kg
        values = np.atleast_1d(getattr(device.beam if hasattr(device.beam, key) else device, key))
        # Under a force, gravity has no effect; neither have values of a mass without one.
        counts = np.equal(device.force, 0) | (key != "gravity")
        counts = counts & ~(device.is_alone & (key in ALONE)) & (values != 0)
        beyond = values[((values < low) | (values > high)) & counts & np.isfinite(values)]
        if beyond.size:
            value, low, high = (used(f"{plain(x)} {unit}", reads) for x in (beyond[0], low, high))
            lines.append(OUTSIDE.format(key, value, low, high))
    return lines


def unusual_runs(**values: np.ndarray | float) -> list[str]:
    """Warn, in lines, of amplitudes N and of a horizon, us, beyond the usual; 0 is usual, too."""
    lines = []
    for key, (low, high, unit) in OF_RUNS.items():
        if beyond := [x for x in np.ravel(values.get(key, 0)) if x and not low <= x <= high]:
            words = (f"{plain(x)} {unit}".rstrip() for x in (beyond[0], low, high))
            lines.append(OUTSIDE.format(key, *words))
    return lines


def wide(plan: Plan) -> list[str]:
    """Warn, in lines, of values that scatter by more than WIDE."""
    lines = []
    for key, scatter in plan.scatters.items():
        share = scatter.width / (1.0 if scatter.is_share else abs(plan.nominal[key]) or math.inf)
        if share > WIDE:
            lines.append(
                f"{key} scatters by {plain(100 * share, 3)} %, more than {100 * WIDE:g} %; is its "
                "width right?"
            )
    return lines


def no_switches(device: Device, plan: Plan, samples: int, seed: int) -> list[str]:
    """Warn, in a line, of devices as made that have no second shape, or cannot be made at all.

    device: nominal; samples, seed: of the devices as made
    """
    try:
        values = plan.values(plan.points(samples, seed)[0])
    except ValueError as error:
        return [str(error)]
    of_device = {key: values[key] for key in values if key not in SHOCK_FACTORS}
    lost = np.count_nonzero(~is_bistable(device, of_device, samples)) if of_device else 0
    return [f"{lost} of {samples} devices as made have no second stable shape"] if lost else []


def implausible(
    device: Device, C: np.ndarray | None, f0: np.ndarray, swings: float = 1.0
) -> list[str]:
    """Warn, in lines, of values of a batch of devices, of C and of f0 that are hardly meant.

    C: uN us/um, ascending; None under a user's own laws; f0: Hz, ascending
    swings: most `Pulse.swings` of the pulses
    """
    beam, lowest = device.beam, device.own_frequency
    mass = np.where(device.is_alone, lowest, device.mass_frequency)
    steepest = np.max(beam.rise / beam.span)
    slender = beam.span / beam.thickness
    widest, thinnest = np.max(beam.depth / beam.span), np.min(beam.depth / beam.thickness)
    critical = np.min(2 * device.mass * mass)
    highest = 0.0 if C is None else C[-1]
    damped = highest / critical if critical else 0.0
    lasts = f0 * (2e-6 * np.pi)
    first, last = np.min(lowest), np.max(np.maximum(mass, beam.bending_frequency))
    lines = {
        f"rise/span = {plain(steepest, 3)}: above {STEEP:g} the arch is not shallow; forces "
        f"come out {plain(FORCES_TOO_HIGH * steepest**2, 2)} % too high, slow thresholds "
        f"{plain(THRESHOLDS_TOO_HIGH * steepest**2, 2)} %": steepest > STEEP,
        f"span/thickness = {plain(slender.min(), 3)}: below {SLENDER[0]:g} shear matters, which "
        "the model ignores": slender.min() < SLENDER[0],
        f"span/thickness = {plain(slender.max(), 3)}: beams have less than {SLENDER[1]:g}; is a "
        "unit wrong?": slender.max() > SLENDER[1],
        f"depth/span = {plain(widest, 3)}: beams have less than {SLAB[1]:g}; is a unit "
        "wrong?": widest > SLAB[1],
        f"depth/thickness = {plain(thinnest, 3)}: beams have more than {SLAB[0]:g}; is a unit "
        "wrong?": thinnest < SLAB[0],
        f"C = {plain(highest)} uN*us/um is {plain(damped, 3)} times critical damping; is its "
        "unit right?": damped > CREEPING,
        f"f0 up to {plain(f0[-1])} Hz: every pulse lasts over {FAR:g} periods of beam and mass, so "
        "it acts as a constant acceleration": lasts[-1] * swings * FAR < first,
        f"f0 from {plain(f0[0])} Hz: every pulse is shorter than 1/{FAR:g} of any period, so it "
        "acts as a jump in velocity": lasts[0] > FAR * last,
    }
    return unusual(device) + [line for line, holds in lines.items() if holds]
