"""What a sensor's data sheet says of a device, each value with its error; as text with units."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from .beam.modal import natural_frequency
from .beam.statics import statics
from .device import Device
from .io.markdown import DASH, table
from .motion.history import extremes_of
from .pulse import DIRECTIONS, shocks_from
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
    several = isinstance(study.device, Mapping)
    sheets = []
    for name, device in study.devices().items():
        one = replace(study, device=device, shocks=shocks_from(SHAPE, "both"))
        found = thresholds_of(one, {"C": C, "f0": 1e3 / np.array(DURATIONS)})
        unit = f"{device.gravity * 1e6:.4g} m/s^2"
        unit = f"{device.force:g} uN on the midpoint" if device.force else unit
        head = ["direction, duration", *(f"C = {c:g} uN*us/um" for c in C)]
        own = [row for row in verdicts if not several or row["device"] == name]
        sheets += [
            f"# Data sheet{f' of {name}' if several else ''}\n",
            table(["at rest, exact to the digits shown", "value"], _statics(device)),
            f"Thresholds of a {SHAPE}, multiples of {unit}:\n",
            table(head, _thresholds(found)),
        ]
        if tolerances:
            made = _spread(one, C, tolerances)
            words = f"Standard deviation over {made.sizes['sample']} devices as made:\n"
            sheets += [words, table(head, _deviations(made))]
        if own:
            head = ["requirement", "C, uN*us/um", "margin", "verdict"]
            sheets += ["Threshold over the required level:\n", table(head, _margins(own))]
        if requirements and own:
            sheets += [
                "Largest under these shocks:\n",
                table(["what", "value", "error", "under"], _largest(one, requirements, own)),
            ]
    return "\n".join(sheets)


def _statics(device: Device):
    path = statics(device)
    resets = f"{-path.least_force:.5g} uN" if path.least_force < 0 else "none: it returns by itself"
    yield ["force that snaps the beam", f"{path.largest_force:.5g} uN"]
    yield ["force that resets it", resets]
    way = device.beam.height - device.beam.second_equilibrium
    yield ["way of the midpoint to the second shape", f"{way:.5g} um"]
    for words, omega in (
        ("first frequency of the beam", natural_frequency(device.beam)),
        ("frequency of the mass on its spring", device.mass_frequency),
    ):
        if np.isinf(omega):
            continue
        yield [words, f"{1e3 * omega / (2 * np.pi):.5g} kHz"]


def _rows(found: xr.Dataset):
    """A name for each direction and duration, and what was found there, over C."""
    for direction in DIRECTIONS:
        for f0 in found.f0.values:
            here = found.sel(direction=direction, f0=f0)
            yield f"{direction}, {1e3 / f0:g} ms", [here.isel(C=i) for i in range(here.sizes["C"])]


def _thresholds(found: xr.Dataset):
    for name, cells in _rows(found):
        yield [name, *map(_threshold, cells)]


def _threshold(one: xr.Dataset) -> str:
    if np.isfinite(one.N_first):
        ragged = ", ragged" if one.ragged else ""
        return f"{one.N_first.item():.5g} ± {one.N_error.item():.2g}{ragged}"
    return f"none up to {one.N_looked.item():.3g}"


def _spread(study: Study, C: Sequence[float], tolerances: Tolerances) -> xr.Dataset:
    samples = min(tolerances.samples, SAMPLES)
    asked = tolerances._replace(samples=samples, index_samples=2)
    return tolerances_of(study, {"C": C, "f0": 1e3 / np.array(DURATIONS)}, asked)


def _deviations(made: xr.Dataset):
    for name, cells in _rows(made):
        yield [name, *(_deviation(one, made.sizes["sample"]) for one in cells)]


def _deviation(one: xr.Dataset, samples: int) -> str:
    share = (one.N_std / one.N_mean).item()
    # The error of a standard deviation of normal numbers.
    return f"{100 * share:.2g} ± {100 * share / np.sqrt(2 * samples):.1g} %" if share > 0 else DASH


def _margins(verdicts: Sequence[Mapping]):
    for row in verdicts:
        margin = f"{row['margin']:.4g} ± {row['margin_error']:.1g}"
        known = np.isfinite(row["margin"])
        must = "trips" if row["must_snap"] else "does not trip"
        words = f"{row['requirement']}, {must}"
        yield [words, f"{row['C']:g}", margin if known else "nothing snaps", row["verdict"]]


def _largest(study: Study, requirements: Sequence[Mapping], verdicts: Sequence[Mapping]):
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
