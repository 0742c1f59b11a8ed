"""The three laws of a device beside its simulated thresholds."""

import numpy as np
import xarray as xr

from ...beam.basis import Basis
from ...beam.equilibria import saddle_and_second, shapes_of
from ...beam.limit_loads import static_threshold
from ...beam.modal import unit_beams
from ...device.device import Beam
from ...files.text import plain
from ...numerics.linalg import apply, dot, eigh, outer
from ...numerics.portable import geometric
from ...solver.adaptive import choose_survey
from ...solver.cells import to_rows
from ...solver.settings import FIRST
from ...study.axes import Grid, point_text
from ...study.study import OF_THRESHOLDS, Study
from ...study.variables import dress
from ...thresholds.probe import Probe, lowest_snap
from ...thresholds.slow import HOLDS, first_obstacle

LN_10 = 2.302585092994046
ABOVE, EXACT = geometric(1e-4, 1e-8, 9), 1e-10
"""Distances above a threshold at which snaps are timed, and the tolerance of the threshold; both
relative."""
WITHIN, STEP = 1e-3, 2e-4
"""The refined threshold is searched within its error bar and WITHIN more, in steps of STEP; both
relative to N."""


def laws_of(study: Study, grid: Grid, thresholds: xr.Dataset) -> xr.Dataset:
    """Compare the laws with thresholds over C and f0, at the first place on all other axes."""
    at = {key: 0 for key in thresholds.N_first.dims if key not in ("C", "f0")}
    thresholds = thresholds.isel(at).sortby("f0")
    f0, kept = thresholds.f0, ["N_first", "N_slow", "N_static", "dwell", "velocity_change"]
    laws = thresholds[kept].drop_attrs()
    laws["N_short"] = 1e-6 * laws.velocity_change * f0 / (thresholds.gravity * thresholds.area)
    slow, fast = (abs(laws[key] / laws.N_first - 1) <= HOLDS for key in ("N_slow", "N_short"))
    laws["slow_to"] = f0.where(slow.cumprod("f0") > 0).max("f0")
    laws["short_from"] = f0.where(fast[:, ::-1].cumprod("f0") > 0).min("f0")
    device = grid.device.pick(grid.device_of.flat[:1])
    rates = saddle_rates(beam := device.pick(0).beam, shapes_of(beam))
    snaps = ("C", "f0"), _snap_scales(study, device, grid.pulses[0], thresholds)
    laws = laws.assign(saddle_scale=("saddle", 1 / rates), snap_scale=snaps)
    laws.dwell.attrs["missing_as"] = _obstacle(study, device.pick(0))
    return dress("laws", laws, study.document(OF_THRESHOLDS))


def _obstacle(study, device):
    """Say why there is no law of slow shocks; empty if there is one."""
    if study.model.laws:
        return "a law of the user's own acts"
    if study.start != FIRST:
        return "runs begin in the second shape"
    return first_obstacle(device, static_threshold(device))


def saddle_rates(beam: Beam, basis: Basis) -> np.ndarray:
    """Find the rates, 1/us, at which one beam leaves the lowest saddle and its mirror image, (2,).

    The first saddle is on the side to which a pulse along +z bends the second mode. The rates are
    NaN without a saddle.
    """
    beams = unit_beams(basis, beam)
    modal, p, _ = saddle_and_second(beams, None)
    axial = beams.axial
    bending = modal.stiffness * np.eye(p.size)
    second = eigh(bending, modal.geometric)[1][..., 1]
    amplitude = dot(second, apply(modal.geometric, p) + modal.slope_start)
    mirrored = p - 2 * amplitude[..., np.newaxis] * second
    p = np.concatenate([mirrored, p] if dot(second, modal.load) * amplitude > 0 else [p, mirrored])
    slope = apply(modal.geometric, p) + modal.slope_start
    N = -axial * dot(p, slope + modal.slope_start)
    stretched = 2 * axial[:, np.newaxis, np.newaxis] * outer(slope, slope)
    tangent = bending - N[:, np.newaxis, np.newaxis] * modal.geometric + stretched
    falls = -eigh(tangent)[0][:, 0] * (beam.stiffness_unit / beam.weight)
    return np.sqrt(falls)


def _snap_scales(study, device, pulse, thresholds):
    """Fit snap times to the logarithm of how far above its threshold each N is, (C, f0)."""
    rows = to_rows(0, thresholds.f0.values, thresholds.C.values[:, np.newaxis], 0, (pulse,))
    N, error = (thresholds[key].values.ravel() for key in ("N_first", "N_error"))
    known, scales = np.isfinite(N + error), np.full(N.size, np.nan)
    rows, N, off = rows.take(known), N[known], (error + WITHIN * N)[known]
    model = choose_survey(device, study.model, study.start).levels[-1].decides
    probe = Probe(model, rows, study.run)
    exact = lowest_snap(probe, (N - off, N + off), EXACT, STEP)
    t_snap = probe(np.multiply.outer(exact, 1 + ABOVE))
    away = (np.arange(ABOVE.size) - (ABOVE.size - 1) / 2) / 2  # decades
    scales[known] = np.sum(t_snap * away, axis=1) / (np.sum(away * away) * LN_10)
    return scales.reshape(thresholds.C.size, -1)


def summary(laws: xr.Dataset) -> str:
    """Write the laws at the first C in a line."""
    keys, laws = ("N_static", "dwell", "velocity_change"), laws.isel(C=0, saddle=0)
    numbers = (laws[key].item() for key in (*keys, "saddle_scale"))
    N, dwell, v, delay = (plain(number) if np.isfinite(number) else "" for number in numbers)
    unknown = f", how long is not known: {laws.dwell.attrs['missing_as']}"
    lasts = f" for longer than {dwell} us" if dwell else unknown
    alone = {key: laws[key].item() for key in laws.coords if laws[key].ndim == 0}
    parts = [
        f"a slow shock trips it above N = {N}{lasts}" if N else "no law of slow shocks holds",
        f"a short one trips it by {v} m/s" if v else "no law of short shocks holds",
        f"a factor e nearer a snap is {delay} us later" if delay else "",
    ]
    return f"at {point_text(alone, laws.C.units)}: {'; '.join(filter(None, parts))}"
