"""Whether records that meet a shock response spectrum trip a device, and at which factor."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...numerics.portable import quarters
from ...pulse.pulse import DIRECTIONS, G, Pulse
from ...solver.adaptive import choose_survey
from ...solver.cells import to_rows
from ...solver.cost import tell
from ...study.arguments import AnyStudy, Axes
from ...study.study import OF_THRESHOLDS, Study
from ...study.variables import dress
from ...thresholds.probe import Probe
from ...thresholds.survey import run_seconds
from ...values.quantities import Dampers, Seed
from .psd import Records
from .srs import Levels, check_points, record

RECORDS, SEED = 8, 1
FACTORS = tuple(quarters(n) for n in range(-8, 9))
"""Factors of the spectrum at which its records are followed: from 12 dB below to 12 dB above."""
PER_RECORD = 120
"""Time that a record takes, over that of a run as forecast: 12 levels, each ten times as long."""


def srs_test(
    study: AnyStudy,
    srs: Levels,
    C: Dampers,
    *,
    records: Records = RECORDS,
    seed: Seed = SEED,
    axes: Axes | None = None,
) -> xr.Dataset:
    """Follow a device under random records that meet a shock response spectrum of Q = 10.

    Parameters
    ----------
    study
        Devices, model, one direction, and how each record is followed; or a Device.
    srs
        Ascending pairs (Hz, multiples of g), interpolated on logarithmic scales.
    C
        Dampings of the mass, uN us/um, each once.
    records
        Number of records, of wavelets at sixth octaves.
    seed
        Seed of the random records.
    axes
        Values of the device, internal units, by name.

    Returns
    -------
    Dataset
        `snaps` (1, 0, or NaN for a failed run) over (..., C, record, factor), and `peak` (g),
        `duration` (us) and the largest `deviation` from the spectrum (dB, with its sign) over
        `record`.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", horizon=0)
    >>> snaps = snapmap.srs_test(study, [(500, 700), (2000, 1500)], 25, records=2).snaps
    >>> snaps.sel(factor=[0.25, 4]).mean("record").squeeze().values.tolist()
    [0.0, 1.0]
    """
    points = check_points(srs)
    study.require_frame("a shock response spectrum")
    if len(study.shocks.directions) > 1:
        raise ValueError("study.direction: has several; write one")
    return trips_of(study, {**(axes or {}), "C": C}, points, {"records": records, "seed": seed})


def trips_of(
    study: Study, axes: Mapping[str, Any], points: np.ndarray, drawn: Mapping
) -> xr.Dataset:
    """Follow a study's devices under records of a spectrum, as `srs_test` returns it.

    axes: values of the device, and C; points: of `check_points`; drawn: number of records, seed
    """
    seeds = [[drawn["seed"], number] for number in range(drawn["records"])]
    records = [record(points, seeds[0])]
    grid = study.set_out(axes)
    rows = to_rows(grid.device_of[..., np.newaxis], 1.0, grid.axes["C"])
    exists, model = rows.device >= 0, choose_survey(grid.device, study.model).decides
    rows, first = rows.take(exists), records[0].pulse
    probe = Probe(model, rows, study.run, "snap")
    tell_records("srs_test", probe, first, len(seeds))
    records += [record(points, seed) for seed in seeds[1:]]
    pulses, peaks, deviations = map(list, zip(*records, strict=True))
    is_upward = DIRECTIONS[study.shocks.directions[0]] > 0
    shaking = pulses if is_upward else [pulse.reversed() for pulse in pulses]
    snaps = np.full((exists.size, len(pulses), len(FACTORS)), np.nan)
    t_snap = snap_times(probe, zip(shaking, peaks, strict=True), FACTORS)
    snaps[exists] = np.where(np.isinf(t_snap), np.nan, np.isfinite(t_snap))
    snaps = snaps.reshape(*grid.shape, len(pulses), len(FACTORS))
    data = {
        "peak": ("record", peaks),
        "duration": ("record", [pulse.duration for pulse in pulses]),
        "deviation": ("record", [dB[abs(dB).argmax()] for dB in deviations]),
        "snaps": ((*grid.axes, "record", "factor"), snaps),
    }
    document = study.document(OF_THRESHOLDS) | {"srs": points.tolist(), **drawn}
    return dress("spectrum", xr.Dataset(data, grid.axes | {"factor": list(FACTORS)}), document)


def tell_records(what: str, probe: Probe, pulse: Pulse, records: int) -> None:
    """Warn if rows under records take long, and refuse them if they take too long.

    what: name of the function; probe: f0 and pulse of its rows do not matter
    pulse: one of the records
    records: their number
    """
    rows = to_rows(probe.rows.device, 1e6 / pulse.duration, probe.rows.C, 0, (pulse,))
    under = probe._replace(rows=rows, until="edge")
    seconds = PER_RECORD * records * float(run_seconds(under).sum()) / probe.settings.threads
    lasts = f"a record of {1e-6 * pulse.duration:.3g} s"
    tell(what, seconds, lasts, "write a higher lowest frequency")


def snap_times(
    probe: Probe, records: Iterable[tuple[Pulse, float]], levels: Sequence[float]
) -> np.ndarray:
    """Find when records at levels snap rows, us, (rows, records, levels).

    probe: f0 and pulse of its rows do not matter; records: pulses with their peaks, g
    levels: factors of the records. A run without a snap has NaN, a failed run -inf.
    """
    pulses, peaks = zip(*records, strict=True)
    device, C = (column[:, np.newaxis] for column in (probe.rows.device, probe.rows.C))
    f0 = [1e6 / pulse.duration for pulse in pulses]
    rows = to_rows(device, f0, C, np.arange(len(pulses)), pulses)
    # A spectrum is in g, whatever N counts.
    N = np.array(peaks)[rows.pulse] * (G / np.atleast_1d(probe.model.device.gravity)[rows.device])
    t_snap = probe._replace(rows=rows)(np.multiply.outer(N, levels))
    return t_snap.reshape(C.size, len(pulses), len(levels))


def ends(snaps: np.ndarray) -> tuple[float, float, float, float]:
    """Find four factors: the highest up to which no run snaps, the lowest at which any run snaps,
    the highest at which any run stays, and the lowest from which all runs snap.

    snaps: 1, 0 or NaN, (runs, factors)
    A highest factor that does not exist is 0, a lowest one inf.
    """
    factors, stays = np.array(FACTORS), snaps == 0
    none = np.logical_and.accumulate(stays.all(axis=0))
    every = np.logical_and.accumulate((snaps == 1).all(axis=0)[::-1])[::-1]
    first = factors[(snaps == 1).any(axis=0)].min(initial=np.inf)
    last = factors[stays.any(axis=0)].max(initial=0)
    return factors[none].max(initial=0), first, last, factors[every].min(initial=np.inf)
