"""Which of the records that meet a shock response spectrum trip a device, and at which level."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..device import Device
from ..io.variables import dress
from ..pulse import DIRECTIONS
from ..solver.adaptive import choose_survey
from ..solver.cells import to_rows
from ..solver.search import asker
from ..study import THRESHOLD_SETTINGS, Study, study_of
from .srs import check_points, record

RECORDS, SEED = 8, 1
FACTORS = tuple(2.0 ** (n / 4) for n in range(-8, 9))
"""Of the spectrum, at which its records are followed: from 12 dB below to 12 dB above."""


def srs_test(
    device: Device | Mapping[str, Device],
    srs: Sequence[Sequence[float]],
    C: Sequence[float],
    records: int = RECORDS,
    seed: int = SEED,
    model: str | Mapping = "auto",
    **options,
) -> xr.Dataset:
    """Follow a device under records that meet a shock response spectrum of Q = 10.

    device: one, or several by name, which then are an axis
    srs: pairs of frequency (Hz) and level (multiples of g), ascending, joined by straight lines on
        logarithmic scales; C: uN us/um
    records: how many are drawn, of wavelets at sixth octaves; seed: of their draw
    options: direction, of one; horizon, energy_tolerance, threads as in `study.study_of`; values of
        the device, as axes; and options of the model
    The variables: snaps, 1 or 0, NaN where a run fails, (..., C, record, factor), the latter of
    FACTORS; the peak of each record, multiples of g, its duration, us, and its largest deviation
    from the spectrum, dB, (record,).
    Records of one spectrum differ: a device passes where none snaps it, or all do, with a margin.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> asked = {"srs": [(500, 700), (2000, 1500)], "records": 2, "model": "cosines", "horizon": 0}
    >>> snaps = snapmap.srs_test(device, C=[25], **asked).snaps
    >>> snaps.sel(factor=[0.25, 4]).mean("record").squeeze().values.tolist()
    [0.0, 1.0]
    """
    points = check_points(srs)
    study, varied = study_of(device, model, options)
    study.require_frame("a shock response spectrum")
    return trips_of(study, {**varied, "C": C}, points, {"records": records, "seed": seed})


def trips_of(
    study: Study, axes: Mapping[str, Sequence[float]], points: np.ndarray, asked: Mapping
) -> xr.Dataset:
    """Follow a study's devices under records of a spectrum, as `srs_test` returns it.

    axes: values of the device, and C; points: as from `check_points`; asked: records, seed
    """
    drawn = [record(points, [asked["seed"], number]) for number in range(asked["records"])]
    along = DIRECTIONS[study.shocks.directions[0]]
    pulses = tuple(one.pulse if along > 0 else one.pulse.reversed() for one in drawn)
    peak = np.array([one.peak for one in drawn])
    grid, settings = study.set_out(axes), study.settings._replace(pulses=pulses)
    f0 = np.array([1e6 / one.duration for one in pulses])
    device = grid.device_of[..., np.newaxis, np.newaxis]
    rows = to_rows(device, f0, grid.axes["C"][:, np.newaxis], np.arange(len(pulses)))
    snaps, there = np.full((rows.device.size, len(FACTORS)), np.nan), rows.device >= 0
    some = rows.some(there)
    ask = asker(choose_survey(grid.device, study.model).decides, some, settings, until="snap")
    t_snap = ask(peak[some.pulse][:, np.newaxis] * FACTORS)
    snaps[there] = np.where(np.isinf(t_snap), np.nan, np.isfinite(t_snap))
    data = {
        "peak": ("record", peak),
        "duration": ("record", [one.pulse.duration for one in drawn]),
        "deviation": ("record", [abs(one.deviation).max() for one in drawn]),
        "snaps": (
            (*grid.axes, "record", "factor"),
            snaps.reshape(*grid.shape, len(pulses), len(FACTORS)),
        ),
    }
    document = study.document(THRESHOLD_SETTINGS) | {"srs": points.tolist(), **asked}
    factors = {"factor": list(FACTORS)}
    return dress("spectrum", xr.Dataset(data, grid.axes | factors), document)


def ends(snaps: np.ndarray) -> tuple[float, float, float, float]:
    """Factors up to which no run snaps, from which one does, up to which one stays, from which all
    snap; 0 or inf where there is none.

    snaps: 1, 0 or NaN, (runs, factors)
    """
    factors, stays = np.array(FACTORS), snaps == 0
    none = np.logical_and.accumulate(stays.all(axis=0))
    every = np.logical_and.accumulate((snaps == 1).all(axis=0)[::-1])[::-1]
    some = (snaps == 1).any(axis=0)
    return (
        *(factors[none].max(initial=0), factors[some].min(initial=np.inf)),
        *(factors[stays.any(axis=0)].max(initial=0), factors[every].min(initial=np.inf)),
    )


def summary(found: xr.Dataset) -> str:
    """One line: the share of records that snaps, below which factor none and from which all do."""
    quiet, _, _, sure = ends(found.snaps.transpose(..., "factor").values.reshape(-1, len(FACTORS)))
    told = [f"{found.snaps.sel(factor=1.0).mean().item():.0%} of the runs snap"]
    told += [f"none up to {quiet:.2g} times it"] if quiet else []
    told += [f"all from {sure:.2g} times it"] if sure < np.inf else []
    return ", ".join(told)
