"""Parts of a data sheet: required shocks, devices as made, and what the model leaves out."""

from collections import Counter
from collections.abc import Iterable, Sequence
from math import pi

import numpy as np
import xarray as xr

from ...device.device import Device
from ...files.text import DASH, plain, table
from ...numerics.portable import evenly
from ...numerics.statistics import percents, scope
from ...pulse.shocks import Shocks
from ...study.axes import PULSE_AXES
from ..histories.history import FARTHEST
from ..requirements.shares import fire_text
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
LEVELS_SHOWN = 12
"""Most rows of no-fire and all-fire."""


def required_shocks(device: Device, verdicts: Sequence[Verdict], of_C: str) -> list[str]:
    """Write a table of two rows for each requirement: its worst corner, and all its others.

    verdicts: the worst first; of_C: C with its unit
    """
    head = ["requirement", "verdict", "devices as made that meet it", "shock", "at, degC", of_C]
    head += ["required", "threshold", "threshold over required", "the beam"]
    head += ["strength over stress", "breaks"]
    groups: dict[str, list[Verdict]] = {}
    for verdict in verdicts:
        groups.setdefault(verdict.requirement, []).append(verdict)
    rows = []
    for worst, *others in groups.values():
        rows.append(_cells(worst))
        if others:
            rows.append(_folded(others))
    of_N = f"{plain(device.gravity * 1e6)} m/s^2"
    of_N = f"{device.force:g} uN on the midpoint" if device.force else of_N
    words = f"Required shocks, each by its worst corner; amplitudes are multiples of {of_N}.\n"
    return [words, ERRORS, table(head, rows), PICTURE]


def _cells(verdict):
    """Cells of one verdict."""
    level, threshold, margin = LEVELS.get(verdict.shape, ""), "nothing snaps", DASH
    required = plain(verdict.N, 5) + level
    if np.isfinite(verdict.scale):
        required += f" ({plain(verdict.scale)} of the record)"
    if np.isfinite(verdict.N_first):
        threshold = f"{verdict.N_first:.5g} ± {plain(verdict.N_error, 2)}"
        threshold += level
        if np.isfinite(verdict.scale_first):
            threshold += f" ({plain(verdict.scale_first)} of the record)"
        margin = f"{plain(verdict.margin)} ± {plain(verdict.margin_error, 1)}"
    is_nominal = np.isfinite(verdict.share) and np.isnan(verdict.share_asked)
    nominal = " by the nominal device" if is_nominal else ""
    asked = f"; asked: {percents(verdict.share_asked)}" if np.isfinite(verdict.share_asked) else ""
    return [
        must_text(verdict.requirement, verdict.must_snap),
        verdict.verdict + nominal + (f"; {OUTSIDE}" if verdict.travel_over_rise > FARTHEST else ""),
        verdict.share_text + asked or DASH,
        verdict.shock,
        plain(verdict.temperature),
        f"{verdict.C:g}",
        required,
        threshold,
        margin,
        verdict.end_text,
        _span([verdict.strength_margin], 3),
        _span([verdict.break_probability] if np.isfinite(verdict.strength_margin) else [], 3),
    ]


def _folded(verdicts):
    """Cells of the other corners of a requirement: counts of words, and ranges of numbers."""

    def span(key, digits=4):
        return _span([getattr(verdict, key) for verdict in verdicts], digits)

    counts = Counter(verdict.verdict for verdict in verdicts)
    words = [f"{count} {word}" for word, count in counts.items()]
    far = sum(verdict.travel_over_rise > FARTHEST for verdict in verdicts)
    words += [f"{far} {OUTSIDE}"] if far else []
    nothing = ", or nothing snaps" if np.isnan([v.N_first for v in verdicts]).any() else ""
    shares = [verdict.share for verdict in verdicts]
    strong = [v.break_probability for v in verdicts if np.isfinite(v.strength_margin)]
    return [
        f"its {len(verdicts)} other corners" if len(verdicts) > 1 else "its other corner",
        ", ".join(words),
        percents(np.nanmin(shares), np.nanmax(shares)) if np.isfinite(shares).any() else DASH,
        "; ".join(dict.fromkeys(verdict.shock for verdict in verdicts)),
        span("temperature"),
        span("C"),
        span("N", 5),
        span("N_first", 5) + nothing,
        span("margin"),
        "; ".join(dict.fromkeys(verdict.end for verdict in verdicts)),
        span("strength_margin", 3),
        _span(strong, 3),
    ]


def _span(values: Iterable[float], digits: int) -> str:
    """Write the range of those numbers that are known."""
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return DASH
    return " to ".join(dict.fromkeys(plain(end, digits) for end in (min(known), max(known))))


def of_batch(made: xr.Dataset, shocks: Shocks, of_C: str) -> list[str]:
    """Write tables of the yield, of what breaks, and of no-fire and all-fire.

    made: dataset of one device, as of `tolerances_of`; shocks: of the study
    """
    size, share = made.sizes["sample"], made.N_all_fire.attrs["share"]
    sure = plain(100 * made.N_all_fire.attrs["confidence"])
    head = [
        "pulse",
        "duration, ms",
        of_C,
        f"no-fire: at most {percents(1 - share)} snap",
        "half snap",
    ]
    head += [f"all-fire: at least {percents(share)} snap"]
    places = list(np.ndindex(made.N_all_fire.shape))
    kept = [places[i] for i in evenly(len(places), LEVELS_SHOWN)]
    few = f" ({len(kept)} of {len(places)})" if len(kept) < len(places) else ""
    pulse = f"{shocks.pulse.name} {shocks.direction}"
    dims = made.N_all_fire.dims
    rows = [_levels(made, dict(zip(dims, place, strict=True)), pulse) for place in kept]
    words = f"Levels of {size} devices as made that snap, at {sure} % confidence{few}:\n"
    tables = [words, table(head, rows)]
    if "yield" in made:
        words = f"Share of {size} devices as made, with bounds at 95 % each:\n"
        tables += [words, table(["share", of_C, "value", "bounds"], _shares(made))]
    return tables


def _levels(made, place, pulse):
    """Cells of the levels at a place; pulse: of the study, unless the place has its own."""
    here = made[["N_no_fire", "N_all_fire", "N_quantile", "ragged"]].isel(place)
    size = made.sizes["sample"]
    named = [str(here[key].item()) for key in PULSE_AXES if key in here.coords]
    half = here.N_quantile.sel(quantile=0.5).item()
    ragged = ", ragged: not at each N above" if here.ragged else ""
    return [
        " ".join(named) or pulse,
        plain(1e3 / here.f0.item()),
        f"{here.C.item():g}",
        fire_text(here.N_no_fire, size),
        plain(half) if np.isfinite(half) else "fewer snap",
        fire_text(here.N_all_fire, size) + ragged,
    ]


def _shares(made):
    """Rows of the shares of devices as made that meet all, and that break, at each C."""
    words = {"yield": f"meet all{scope(made['yield'])}", "share_breaking": "break under"}
    for key in filter(made.data_vars.__contains__, words):
        for place in np.ndindex(made[key].shape):
            at = made[[key, f"{key}_bound"]].isel(dict(zip(made[key].dims, place, strict=True)))
            under = [at.requirement.item()] if "requirement" in at.coords else []
            bounds = percents(*at[f"{key}_bound"].values)
            yield [" ".join([words[key], *under]), f"{at.C.item():g}", percents(at[key]), bounds]


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
