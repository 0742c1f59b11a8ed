"""Follow many cells with one model: choose the loop, share out threads, repeat what failed."""

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from .device import Device
from .lanes import device_coefficients, follow_lanes
from .models import Model
from .protocol import Protocol
from .reference import follow, nodal_system

HALVINGS = 4
"""How often a cell whose energy ledger does not close is followed again with half the step."""


class Facts(NamedTuple):
    """What was observed of each cell; arrays of one length.

    t_snap: first arrival of the midpoint at w2 after the pulse's start, us; NaN if not seen
    t_settled: when the beam was seen to be settled in a well for ever, us; NaN if it was not
    well: that well, 1 or 2; 0 if it was not
    energy_error: residual of the energy ledger over the gross work of the pulse
    halvings: how often the model's step was halved for these observations
    """

    t_snap: np.ndarray
    t_settled: np.ndarray
    well: np.ndarray
    energy_error: np.ndarray
    halvings: np.ndarray


class Cells(NamedTuple):
    """Cells in internal units; arrays of one length.

    amplitude: N g, um/us^2; f0: 1/us; damping: C, uN us/um; t_end: us
    """

    amplitude: np.ndarray
    f0: np.ndarray
    damping: np.ndarray
    t_end: np.ndarray


def check_cells(**values) -> None:
    """Raise ValueError, one line, unless N is finite, f0 above 0 and C from 0."""
    least = {"N": -np.inf, "f0": np.nextafter(0, 1), "C": 0.0}
    need = {"N": "any size", "f0": "above 0", "C": "0 or above"}
    for key, given in values.items():
        try:
            given = np.atleast_1d(np.asarray(given, float))
        except (TypeError, ValueError):
            raise ValueError(f"{key}: {given!r} is no number, nor an array of numbers") from None
        if given.size == 0:
            raise ValueError(f"{key}: empty; give one value or more")
        wrong = given[~(np.isfinite(given) & (given >= least[key]))]
        if wrong.size:
            raise ValueError(f"{key}: {wrong[0]:g} cannot be; it must be finite and {need[key]}")


def to_cells(device: Device, N, f0, C, horizon: float) -> Cells:
    """Convert cells from multiples of g, Hz, uN us/um and a horizon after the pulse in us."""
    f0 = np.asarray(f0, float) * 1e-6
    return Cells(
        amplitude=np.asarray(N, float) * device.gravity,
        f0=f0,
        damping=np.asarray(C, float),
        t_end=1 / f0 + horizon,
    )


def follow_cells(model: Model, cells: Cells, protocol: Protocol, threads: int = 1) -> Facts:
    """Follow every cell as the protocol asks.

    A cell whose ledger does not close is followed again with half the step, up to HALVINGS times:
    hard impacts ask for less than the stability limit does.
    """
    facts = follow_once(model, cells, protocol, threads)
    for halvings in range(1, HALVINGS + 1):
        doubtful = np.flatnonzero(~(facts.energy_error <= protocol.energy_tolerance))
        if doubtful.size == 0:
            break
        model = model.with_step(0.5)
        some = Cells(*(values[doubtful] for values in cells))
        again = follow_once(model, some, protocol, threads)
        for known, new in zip(facts, again, strict=True):
            known[doubtful] = new
        facts.halvings[doubtful] = halvings
    return facts


def follow_once(model: Model, cells: Cells, protocol: Protocol, threads: int = 1) -> Facts:
    """Follow every cell with the model's own step, whatever its ledger then says."""
    n_cells = cells.f0.size
    kinds = float, float, np.int8, float, np.int8
    facts = Facts(*(np.zeros(n_cells, kind) for kind in kinds))
    follow_some = _follow_reference if model.name == "reference" else _follow_lanes
    shares = [np.arange(first, n_cells, threads) for first in range(threads)]

    def follow_share(share):
        share = share[np.argsort(cells.f0[share], kind="stable")]
        some = Cells(*(values[share] for values in cells))
        found = follow_some(model, some, protocol)
        for whole, part in zip(facts[: len(found)], found, strict=True):
            whole[share] = part

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(follow_share, shares))
    facts.t_snap[facts.t_snap > cells.t_end] = np.nan
    late = facts.t_settled > cells.t_end
    facts.t_settled[late], facts.well[late] = np.nan, 0
    return facts


def _follow_lanes(model, cells, protocol):
    row = device_coefficients(model, _target(model))
    device_of = np.zeros(cells.f0.size, np.int64)
    return follow_lanes(
        model.modal.load.size,
        row[np.newaxis],
        np.array([model.dt]),
        (device_of, *cells),
        protocol.until == "snap",
    )


def _follow_reference(model, cells, protocol):
    """The plain loop proves nothing: it ends at the snap or the horizon, whatever is asked."""
    system = nodal_system(model.device, model.basis)
    no_history = np.empty((0, 2 * system.load.size + 4))
    steps = np.ceil(cells.t_end / model.dt).astype(int)
    found = [
        follow(system, amplitude, f0, damping, _target(model), model.dt, n, no_history)
        for amplitude, f0, damping, n in zip(*cells[:3], steps, strict=True)
    ]
    t_snap, energy_error = np.array(found).reshape(-1, 2).T
    return t_snap, np.full(t_snap.size, np.nan), np.zeros(t_snap.size, np.int8), energy_error


def _target(model):
    beam = model.device.beam
    return beam.second_equilibrium - beam.rise
