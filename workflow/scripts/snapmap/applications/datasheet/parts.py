"""Parts of a data sheet: required shocks, devices as made, and what the model leaves out."""

from collections.abc import Iterable, Sequence
from math import pi

import numpy as np
import xarray as xr

from ...device.device import Device
from ...files.text import DASH, plain, table
from ...numerics.portable import evenly
from ...numerics.statistics import percents, scope
from ...pulse.shocks import Shocks
from ...study.axes import DIRECTION, SHAPE
from ..histories.history import FARTHEST
from ..requirements.shares import missing_fire
from ..requirements.summary import LEVELS
from ..requirements.verdict import Verdict, must_text

OUTSIDE = "outside any package: not valid"
"""Mark of results in which the mass travels beyond FARTHEST rises on a side without a stop."""
PICTURE = "![margins of the requirements](figures/requirements.png)\n"
ERRORS = (
    "± is the error of the calculation alone, for the nominal device: of the search, the time step "
    "and the number of shapes. It has no scatter of devices, and nothing that the model leaves "
    "out.\n"
)
NEVER = "some devices never snap"
LEVELS_SHOWN = 12
"""Most rows of no-fire and all-fire."""


def required_shocks(device: Device, verdicts: Sequence[Verdict], of_C: str) -> list[str]:
    """Write a table of two rows for each requirement: its worst corner, and all its others.

    verdicts: the worst first; of_C: C with its unit
    """
    head = ["requirement", "verdict", "devices as made that meet it", "shock", "at, degC", of_C]
    head += ["required", "threshold", "threshold over required", "the beam"]
    head += ["strength over stress", "breaks"]
    rows = []
    for name in dict.fromkeys(verdict.requirement for verdict in verdicts):
        worst, *others = (verdict for verdict in verdicts if verdict.requirement == name)
        rows.append([must_text(name, worst.must_snap), *_cells([worst])])
        if others:
            rows.append([f"its other corners, {len(others)}", *_cells(others)])
    of_N = f"{plain(device.gravity * 1e6)} m/s^2"
    of_N = f"{device.force:g} uN on the midpoint" if device.force else of_N
    words = f"Required shocks, each by its worst corner; amplitudes are multiples of {of_N}.\n"
    return [words, ERRORS, table(head, rows), PICTURE]


def _cells(verdicts):
    """Cells of one corner, or of several: their words, and the ranges of their numbers."""
    first = verdicts[0]
    level = LEVELS.get(first.shape, "")

    def span(key, digits=4, error=""):
        known = [getattr(verdict, key) for verdict in verdicts]
        words = _span(known, digits)
        if error and len(verdicts) == 1 and np.isfinite(known[0]):
            words += f" ± {plain(getattr(first, error), 2)}"
        return words

    def amplitude(key, scale, error=""):
        factor, of = getattr(first, scale), "drop" if first.drop else "record"
        is_told = np.isfinite(factor) and not (first.drop and factor == 1)
        return span(key, 5, error) + level + (f" ({span(scale)} of the {of})" if is_told else "")

    def joined(words):
        return "; ".join(dict.fromkeys(words))

    threshold, never = [], np.isnan([verdict.N_first for verdict in verdicts])
    if not never.all():
        threshold.append(amplitude("N_first", "scale_first", "N_error"))
    if never.any():
        threshold.append("nothing snaps")
    words = [verdict.verdict_text for verdict in verdicts]
    is_outside = any(verdict.travel_over_rise > FARTHEST for verdict in verdicts)
    return [
        joined(words + [OUTSIDE] * is_outside),
        joined(verdict.share_text or DASH for verdict in verdicts),
        joined(verdict.shock for verdict in verdicts),
        span("temperature"),
        span("C"),
        amplitude("N", "scale"),
        " or ".join(threshold),
        span("margin", 4, "margin_error"),
        joined(verdict.end_text for verdict in verdicts),
        span("strength_margin", 3),
        span("break_probability", 3) if np.isfinite(first.strength_margin) else DASH,
    ]


def _span(values: Iterable[float], digits: int) -> str:
    """Write the range of those numbers that are known."""
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return DASH
    return " to ".join(dict.fromkeys(plain(end, digits) for end in (min(known), max(known))))


def of_batch(made: xr.Dataset, shocks: Shocks, of_C: str) -> list[str]:
    """Write tables of no-fire and all-fire, and of the yield.

    made: dataset of one device, as of `tolerances_of`; shocks: of the study
    """
    size, tables = made.sizes["sample"], _levels(made, shocks, of_C)
    if "yield" in made:
        shares = zip(made.C.values, made["yield"].values, made.yield_bound.values.T, strict=True)
        rows = [[f"{C:g}", percents(one), percents(*bounds)] for C, one, bounds in shares]
        words = f"Share of {size} devices as made that meet all{scope(made['yield'])}:\n"
        tables += [words, table([of_C, "share", "bounds at 95 % each"], rows)]
    return tables


def _levels(made, shocks, of_C):
    """Write the table of no-fire and all-fire, or how many devices they take."""
    size, fire, degrees = made.sizes["sample"], made.N_all_fire, plain(made.temperature.item())
    few, ends = missing_fire(fire, size), ("N_no_fire", "N_all_fire")
    words = f"No-fire (at most {percents(1 - fire.share)} snap) and all-fire (at least "
    words += f"{percents(fire.share)} snap) of {size} devices as made at {degrees} degC, "
    words += f"at {plain(100 * fire.confidence)} % confidence"
    if few:
        return [f"{words}: {few}.\n"]
    levels = made[[*ends, "ragged"]].to_dataframe().reset_index()
    kept = levels.iloc[evenly(len(levels), LEVELS_SHOWN)]
    names = {SHAPE: shocks.pulses[0].name, DIRECTION: shocks.directions[0]}
    rows = [
        [
            f"{level[SHAPE]} {level[DIRECTION]}" + (", ragged" if level["ragged"] else ""),
            plain(1e3 / level["f0"]),
            f"{level['C']:g}",
            *(plain(level[key]) if np.isfinite(level[key]) else NEVER for key in ends),
        ]
        for level in (names | row for row in kept.to_dict("records"))
    ]
    part = f" ({len(kept)} of {len(levels)} pulses)" if len(kept) < len(levels) else ""
    head = ["pulse", "duration, ms", of_C, "no-fire", "all-fire"]
    return [f"{words}{part}:\n", table(head, rows)]


def left_out(device: Device) -> list[str]:
    """Write what the model leaves out, with the change of the threshold."""
    beam, example = device.beam, "measured on the example of the documents, 1500 Hz"
    slope, shear = pi * beam.rise / beam.span, 2 * pi * beam.thickness / beam.span
    rows = [
        ["anchors that turn", "-1.5 %", example],
        ["gas that is squeezed: C from 0.025 to 200 uN us/um", "-0.7 to +6.3 %", example],
        ["an equal shock before", "-4.1 %", example],
        ["resonance of the package", "to -41 %", "an oscillator"],
        ["slope of the beam", f"some {plain(100 * slope**2, 1)} %", "(pi rise/span)^2"],
        ["shear in the beam", f"some {plain(100 * shear**2, 1)} %", "(2 pi thickness/span)^2"],
        ["rotation of the mass, other directions, friction, adhesion", "not known", DASH],
        ["thresholds measured on devices", "none is compared here", "calibration does"],
    ]
    if not device.is_alone:
        lost = 50 * beam.weight / (device.mass + beam.weight)
        rows.append(["an inelastic impact", f"to +{plain(lost, 1)} %", "half of m/(M + m)"])
    return ["What the model leaves out:\n", table(["cause", "threshold", "by"], rows)]
