"""What a sensor's data sheet says of a device, each value with its error; as text with units."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from .beam.modal import natural_frequency
from .beam.statics import statics
from .io.markdown import DASH, table
from .motion.history import extremes_of
from .pulse import DIRECTIONS
from .shocks import make_shocks
from .solver.outcome import REPEATED_STEP
from .study import Study
from .thresholds.surface import thresholds_of
from .tolerances.dataset import tolerances_of
from .tolerances.samples import Tolerances

SHAPE, DURATIONS = "half sine", (0.1, 0.2, 0.5, 1.0, 2.0, 6.0, 11.0)
"""Of the shocks in IEC 60068-2-27 and JESD22-B110; ms."""
SAMPLES = 256
"""Most devices as made of which the spread is found."""
UNITS = {
    "toward_max": ("way of the mass towards the beam", "um"),
    "away_max": ("way of the mass away from the beam", "um"),
    "contact_force_max": ("force between mass and beam, an indicator", "uN"),
    "stress_max": ("tensile stress in the beam", "MPa"),
}
"""Of `Extremes`, as a data sheet names them."""


def datasheet(
    study: Study,
    C: Sequence[float],
    tolerances: Tolerances | None = None,
    requirements: Sequence[Mapping] = (),
    verdicts: Sequence[Mapping] = (),
) -> str:
    """Write the data sheets of a study's devices, in Markdown.

    study: whose pulse is of no account; C: uN us/um; tolerances: what scatters, if it is known
    requirements: as `thresholds.requirements.check` takes them; verdicts: rows of requirements.csv
    """
    several, sheets = isinstance(study.device, Mapping), []
    axes = {"C": C, "f0": 1e3 / np.array(DURATIONS)}
    head = ["direction, duration", *(f"C = {c:g} uN*us/um" for c in C)]
    for name, device in study.devices().items():
        sheets += [
            f"# Data sheet{f' of {name}' if several else ''}\n",
            table(["at rest, exact to the digits shown", "value"], _statics(device)),
        ]
        if not device.beam.is_bistable:
            sheets.append("Its beam has no second stable shape, so there is no threshold.\n")
            continue
        one = replace(study, device=device, shocks=make_shocks(SHAPE, "both"))
        unit = f"{device.gravity * 1e6:.4g} m/s^2"
        unit = f"{device.force:g} uN on the midpoint" if device.force else unit
        rows = _rows(thresholds_of(one, axes), _threshold)
        sheets += [f"Thresholds of a {SHAPE}, multiples of {unit}:\n", table(head, rows)]
        if tolerances:
            few = min(tolerances.samples, SAMPLES)
            made = tolerances_of(one, axes, tolerances._replace(samples=few, index_samples=2))
            words = f"Standard deviation over {made.sizes['sample']} devices as made:\n"
            sheets += [words, table(head, _rows(made, _deviation))]
        if own := [row for row in verdicts if not several or row["device"] == name]:
            of = ["requirement", "C, uN*us/um", "margin", "verdict"]
            sheets += ["Threshold over the required level:\n", table(of, map(_margin, own))]
            if requirements:
                of = ["what", "value", "error", "under"]
                largest = table(of, _largest(one, requirements, own))
                sheets += ["Largest under these shocks:\n", largest]
    return "\n".join(sheets)


def _statics(device):
    path, beam = statics(device), device.beam
    resets = f"{-path.least_force:.5g} uN" if path.least_force < 0 else "none: it returns by itself"
    yield ["force that snaps the beam", f"{path.largest_force:.5g} uN"]
    yield ["force that resets it", resets]
    if beam.is_bistable:
        way = beam.height - beam.second_equilibrium
        yield ["way of the midpoint to the second shape", f"{way:.5g} um"]
    yield ["first frequency of the beam", f"{1e3 * natural_frequency(beam) / (2 * np.pi):.5g} kHz"]
    if not device.is_alone:
        own = f"{1e3 * device.mass_frequency / (2 * np.pi):.5g} kHz"
        yield ["frequency of the mass on its spring", own]


def _rows(found, words):
    """A row for each direction and duration: its name, and `words` of what was found at each C."""
    for direction in DIRECTIONS:
        for f0 in found.f0.values:
            here = found.sel(direction=direction, f0=f0)
            cells = (words(here.isel(C=i)) for i in range(here.sizes["C"]))
            yield [f"{direction}, {1e3 / f0:g} ms", *cells]


def _threshold(one: xr.Dataset) -> str:
    if np.isfinite(one.N_first):
        ragged = ", ragged" if one.ragged else ""
        return f"{one.N_first.item():.5g} ± {one.N_error.item():.2g}{ragged}"
    return f"none up to {one.N_looked.item():.3g}"


def _deviation(one: xr.Dataset) -> str:
    share = (one.N_std / one.N_mean).item()
    # The error of a standard deviation of normal numbers.
    error = 100 * share / np.sqrt(2 * one.sizes["sample"])
    return f"{100 * share:.2g} ± {error:.1g} %" if share > 0 else DASH


def _margin(row):
    margin = f"{row['margin']:.4g} ± {row['margin_error']:.1g}"
    known = np.isfinite(row["margin"])
    must = "trips" if row["must_snap"] else "does not trip"
    words = f"{row['requirement']}, {must}"
    return [words, f"{row['C']:g}", margin if known else "nothing snaps", row["verdict"]]


def _largest(study, requirements, verdicts):
    """What is largest under all required shocks, and its error: the difference to another step."""
    asked = {one["name"]: one for one in requirements}
    shocks = [row for row in verdicts if row["requirement"] in asked]
    for key, (words, unit) in UNITS.items():
        if not np.isfinite([row[key] for row in shocks]).any():
            continue
        worst = max(shocks, key=lambda row, key=key: row[key])
        one = asked[worst["requirement"]]
        under = replace(study, shocks=one["shocks"])
        again = extremes_of(under, one["N"], one["f0"], worst["C"], step=REPEATED_STEP)
        value, other = worst[key], getattr(again, key)
        where = f"{worst['requirement']}, C = {worst['C']:g}"
        yield [words, f"{value:.4g} {unit}", f"{abs(value - other):.1g} {unit}", where]
