"""How probably random vibration trips a device, and the level that a device withstands."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import numpy as np
import xarray as xr

from ...pulse.shocks import HANDOUT_SHOCK
from ...solver.adaptive import choose_survey
from ...solver.cells import to_rows
from ...study.arguments import AnyStudy, Axes
from ...study.study import OF_THRESHOLDS, Study
from ...study.variables import dress
from ...thresholds.probe import Probe
from ...values.quantities import Dampers, Fraction, Seed, single
from .psd import REACH, Density, Records, Spectrum
from .trips import snap_times, tell_records

RECORDS, SEED = 16, 1
"""Default number of records, and seed of their phases."""
RUNG = 2**0.25
"""Ratio of neighbouring levels; a level is RUNG to the power of its rung, over the given level."""
STRIDE, FARTHEST = 4, 60
"""Rungs between the first levels, and the largest number of rungs from the given level."""
RUNGS = 4
"""Number of rungs, from the lowest that snaps, in a fit of rates; Rice's law fails far above it."""
STEP = 4.0
"""Time step for a record over that for a threshold: docs/applications/spectra.md gives reasons."""
PIECES = 2_000_000
"""Pieces of the records that are followed at a time, 96 MB."""
NORMAL = 1.959964
"""Standard deviations on either side of the mean that hold 95 % of normal numbers."""
ENOUGH = 1e-12
"""Least determinant of a fit, relative, at which its slope is determined."""


Seconds = Annotated[float | str, single("a duration", "s", "60 s")]


def vibration(
    study: AnyStudy,
    psd: Density,
    duration: Seconds,
    C: Dampers,
    *,
    records: Records = RECORDS,
    seed: Seed = SEED,
    reach: Fraction = REACH,
    axes: Axes | None = None,
) -> xr.Dataset:
    """Find how often Gaussian vibration snaps a device, and the strength that it withstands.

    Parameters
    ----------
    study
        Devices and model, or a Device; `auto` takes 5 cosines.
    psd
        One-sided density, as ascending pairs (Hz, g^2/Hz), interpolated on logarithmic scales.
    duration
        Duration of the vibration, s.
    C
        Dampings of the mass, uN us/um, each once.
    records
        Number of records from rest, each of a second or ten periods of the lowest frequency, at
        most the duration.
    seed
        Seed of the random phases.
    reach
        Probability of a snap within the duration, for which `level` is found.
    axes
        Values of the device, internal units, by name.

    Returns
    -------
    Dataset
        Over (..., C): `rate` and `probability` under this spectrum, with Poisson's bounds, and the
        strength `level` (g rms) of the same spectrum that has the probability `reach`, with
        bounds: NaN if the runs do not determine it, inf if none snaps at any strength. `rms` is
        that of the spectrum as given (g).

    Raises
    ------
    ValueError
        A line for each argument that is wrong.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study, psd = snapmap.Study(device, model="cosines"), [(20, 4.0), (2000, 4.0)]
    >>> rates = snapmap.vibration(study, psd, 0.1, 25, records=2, reach=0.5)
    >>> round(rates.rms.item()), rates.snaps.values.tolist()
    (89, [0.0])
    """
    study.require_frame("random vibration")
    spectrum = Spectrum(psd)
    spectrum.require_record(duration)
    drawn = {"duration": duration, "records": records, "seed": seed, "reach": reach}
    return vibration_of(study, {**(axes or {}), "C": C}, spectrum, drawn)


def vibration_of(
    study: Study, axes: Mapping[str, Any], spectrum: Spectrum, drawn: Mapping
) -> xr.Dataset:
    """Find the rate and the level of a study's devices, as `vibration` returns them.

    study: its pulse does not matter
    axes: values of the device, and C; drawn: duration, records, seed and reach
    """
    study = study.under(HANDOUT_SHOCK)
    grid = study.set_out(axes)
    T, records, seed, reach = (drawn[key] for key in ("duration", "records", "seed", "reach"))
    length, rms = spectrum.record_length(T), spectrum.rms
    model = choose_survey(grid.device, study.model).decides.with_step(STEP)
    rows = to_rows(grid.device_of[..., np.newaxis], 1.0, grid.axes["C"])
    probe = Probe(model, rows, study.run.but(horizon=0.0), "snap")
    first, _ = spectrum.record(length, [seed, 0])
    together = max(1, PIECES // len(first.pieces))

    def follow(which, level):
        """Numbers of records that snap and fail, and time followed, s, by row, (3, rows)."""
        counts = np.zeros((3, which.size))
        for begin in range(0, records, together):
            numbers = range(begin, min(begin + together, records))
            pulses = [spectrum.record(length, [seed, number]) for number in numbers]
            t_snap = snap_times(probe.take(which), pulses, [level])[..., 0]
            failed, snapped = np.isinf(t_snap), np.isfinite(t_snap)
            time = np.where(snapped, t_snap * 1e-6, np.where(failed, 0.0, length))
            counts += [column.sum(axis=1) for column in (snapped, failed, time)]
        return counts

    exists = rows.device >= 0
    tell_records("vibration", probe.take(exists), first, records)
    ladder = _climb(follow, exists, records)
    needed = -math.log1p(-reach) / T
    levels = np.array([_level(ladder, row, needed) for row in range(exists.size)]) * rms
    data = _rates(ladder[0], T)
    data |= dict(zip(("level", "level_low", "level_high"), levels.T, strict=True))
    section = {"psd": [spectrum.f.tolist(), spectrum.density.tolist()], **drawn}
    document = study.document(OF_THRESHOLDS) | {"vibration": section}
    columns: dict[str, Any] = {
        key: (tuple(grid.axes), np.where(exists, values, np.nan).reshape(grid.shape))
        for key, values in data.items()
    }
    columns |= {"rms": rms, "record_length": length}
    return dress("vibration", xr.Dataset(columns, grid.axes), document, **drawn)


def _climb(follow: Callable, exists: np.ndarray, records: int) -> dict[int, np.ndarray]:
    """Count snaps at rungs around the given level, rung 0, from where none snaps to where all do.

    follow: a function of row numbers and a level that returns snaps, failed and time, (3, rows)
    exists: rows that have a device
    Returns the same by rung, every one near the lowest snap, else every STRIDE-th; NaN for rows
    not followed there.
    """
    ladder: dict[int, np.ndarray] = {}

    def count(rung, which):
        counts = ladder.setdefault(rung, np.full((3, exists.size), np.nan))
        which = which[np.isnan(counts[0, which])]
        if which.size:
            counts[:, which] = follow(which, RUNG**rung)
        return counts

    every = np.flatnonzero(exists)
    all_snap, none_snaps = np.full((2, exists.size), 0)
    for last, side in ((all_snap, 1), (none_snaps, -1)):
        rung, left = 0, every
        while left.size and abs(rung) <= FARTHEST:
            snaps, failed, _ = count(rung, left)[:, left]
            stays = snaps + failed < records if side > 0 else snaps > 0
            last[left], left, rung = rung, left[stays], rung + side * STRIDE
    for rung in range(none_snaps[every].min(initial=0), all_snap[every].max(initial=0)):
        low = np.array([_last_quiet(ladder, row) for row in every], np.int64)
        count(rung, every[(low < rung) & (rung < all_snap[every])])
    return ladder


def _counts(ladder, row):
    """Snaps and time of a row by rung, ascending, at rungs where runs did not all fail."""
    return {rung: ladder[rung][::2, row] for rung in sorted(ladder) if ladder[rung][2, row] > 0}


def _last_quiet(ladder, row):
    """The highest rung below all snaps so far, or else the lowest rung; 0 if all runs failed."""
    counts = _counts(ladder, row)
    first = next((rung for rung, (snaps, _) in counts.items() if snaps > 0), math.inf)
    return max((rung for rung in counts if rung < first), default=min(counts, default=0))


def _level(ladder: Mapping[int, np.ndarray], row: int, needed: float) -> tuple[float, ...]:
    """Find the level over the given one at which the rate is `needed`, 1/s, and its bounds."""
    counts = _counts(ladder, row)
    first = next((rung for rung, (snaps, _) in counts.items() if snaps > 0), None)
    if first is None:
        return (np.inf,) * 3 if counts else (np.nan,) * 3
    near = [(RUNG ** (-2 * rung), *counts[rung]) for rung in counts if rung < first + RUNGS]
    a, b, variance = fit_rates(*zip(*near, strict=True))
    if not b > 0:
        return np.nan, 0.0, np.inf
    reached = (a - math.log(needed)) / b
    spread = math.sqrt(variance(reached)) / b
    bounds = reached, reached + NORMAL * spread, reached - NORMAL * spread
    return tuple(end**-0.5 if end > 0 else np.inf for end in bounds)


def fit_rates(x: Sequence[float], counts: Sequence[float], times: Sequence[float]):
    """Fit Rice's law ln(rate) = a - b x to counts in times, by maximum Poisson likelihood.

    x: 1/level^2
    Returns a, b, and a function of x that gives the variance of a - b x, raised by the scatter of
    the counts about the law. If the counts do not determine b, it is 0 and the variance inf.
    """
    a, b = math.log(sum(counts) / sum(times)), 0.0
    for _ in range(100):
        expected = [t * math.exp(min(a - b * xi, 700.0)) for xi, t in zip(x, times, strict=True)]
        s0, s1, s2 = (sum(m * xi**k for xi, m in zip(x, expected, strict=True)) for k in range(3))
        g0 = sum(n - m for n, m in zip(counts, expected, strict=True))
        g1 = sum((n - m) * xi for n, m, xi in zip(counts, expected, x, strict=True))
        det = s0 * s2 - s1 * s1
        if not det > ENOUGH * s0 * s2:
            return a, 0.0, lambda xi: np.inf
        da, db = (s2 * g0 - s1 * g1) / det, (s1 * g0 - s0 * g1) / det
        a, b = a + da, b + db
        if abs(da) + abs(db) < 1e-9 * (1 + abs(a) + abs(b)):
            break
    residual = sum((n - m) ** 2 / m for n, m in zip(counts, expected, strict=True) if m > 0)
    scatter = max(1.0, residual / max(1, len(x) - 2))
    return a, b, lambda xi: scatter * (s2 - 2 * s1 * xi + s0 * xi * xi) / det


def _rates(counts: np.ndarray, T: float) -> dict[str, np.ndarray]:
    """Rate and probability within T, s, with bounds by Poisson's distribution."""
    from scipy.special import chdtri  # half a second, for which nobody else has to wait

    n, failed, time = counts
    with np.errstate(divide="ignore", invalid="ignore"):
        rates = {
            "rate": n / time,
            "rate_low": np.where(n > 0, chdtri(2 * n, 0.975) / (2 * time), 0.0),
            "rate_high": chdtri(2 * n + 2, 0.025) / (2 * time),
        }
    chances = {
        key.replace("rate", "probability"): -np.expm1(-rate * T) for key, rate in rates.items()
    }
    return {"snaps": n, "simulated": time, "failed": failed} | rates | chances
