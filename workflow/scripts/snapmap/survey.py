"""Thresholds as a product: where snapping begins and where it is certain, with an error bar."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .device import Device
from .ladder import Ladder, build_ladder
from .models import Model
from .protocol import Protocol
from .thresholds import asker, first_snap, refine

FINE_STEP = 0.005
"""Relative distance of the amplitudes between which islands are looked for."""
BELOW, ABOVE = 0.7, 2.0
"""Where islands are looked for, as multiples of the threshold found first."""


class Survey(NamedTuple):
    """Thresholds of rows, (rows,), in multiples of g; NaN where none was found.

    N_first: the lowest N that snaps
    N_always: the lowest above which every N looked at snaps, up to ABOVE times N_first
    N_error: of N_first: what the finer levels, half the step and the refinement leave open
    islands: number of separate stretches of N below N_always that snap
    """

    N_first: np.ndarray
    N_always: np.ndarray
    N_error: np.ndarray
    islands: np.ndarray


def survey(
    device: Device,
    model: Model | Ladder,
    f0: Sequence[float],
    C: Sequence[float],
    protocol: Protocol,
    tolerance: float = 1e-4,
    threads: int = 1,
) -> Survey:
    """Find thresholds for rows of f0 (Hz) and C (uN us/um), to a relative tolerance.

    The cheapest level scans; the model itself (of a ladder the top) refines what it found.
    """
    ladder = model if isinstance(model, Ladder) else build_ladder(device)
    decides, doubts = (ladder.top, ladder.check) if model is ladder else (model, ladder.top)

    f0, C = (np.asarray(values, float) for values in (f0, C))

    def refined(level, guess):
        def ask(rows):
            return asker(device, level, f0[rows], C[rows], protocol, threads)

        return _refine_about(ask, guess, tolerance)

    scan = asker(device, ladder.base, f0, C, protocol, threads)
    first = first_snap(wide := _wide_scan(device, f0), scan(wide))[1]
    first, always, islands = _islands(scan, first)
    N_first = refined(decides, first)
    N_error = abs(N_first - refined(doubts, N_first)) + tolerance * N_first
    N_error += abs(N_first - refined(decides.with_step(0.5), N_first))
    # Where nothing lies between, both are one threshold, and the finer level knows it better.
    N_always = np.where(islands == 0, N_first, always)
    return Survey(N_first, N_always, N_error, islands)


def _wide_scan(device, f0):
    """Amplitudes, (rows, n), from far below any threshold to far above, also of short pulses."""
    own_frequency = np.sqrt(device.spring / device.mass) / (2 * np.pi) * 1e6
    weight = device.spring * device.beam.rise / (device.mass * device.gravity)
    highest = 30 * weight * (1 + np.asarray(f0) / own_frequency)
    count = 2 + int(np.log(np.max(highest) / weight * 30) / 0.04)
    return np.geomspace(np.full(len(f0), weight / 30), highest, count, axis=1)


def _islands(scan, first):
    """First and last threshold on a fine scan, and the number of islands between them."""
    count = 1 + int(np.log(ABOVE / BELOW) / FINE_STEP)
    N = np.nan_to_num(first)[:, np.newaxis] * np.geomspace(BELOW, ABOVE, count)
    snapped = scan(N) & np.isfinite(first)[:, np.newaxis]
    rises = np.count_nonzero(snapped[:, 1:] & ~snapped[:, :-1], axis=1)
    last_quiet = snapped.shape[1] - 1 - np.argmax(~snapped[:, ::-1], axis=1)
    always = N[np.arange(len(N)), np.minimum(last_quiet + 1, count - 1)]
    closed = np.isfinite(first) & (last_quiet < count - 1)
    return first_snap(N, snapped)[1], np.where(closed, always, np.nan), np.maximum(rises - 1, 0)


def _refine_about(ask, guess, tolerance):
    """Refine with another model what one found; ask(rows) gives its `snaps` for some rows."""
    found = np.full(guess.size, np.nan)
    for reach, count in ((0.02, 9), (0.15, 61)):  # ragged thresholds of short pulses lie far apart
        rows = np.flatnonzero(np.isfinite(guess) & np.isnan(found))
        if rows.size:
            snaps = ask(rows)
            N = guess[rows, np.newaxis] * np.linspace(1 - reach, 1 + reach, count)
            found[rows] = refine(snaps, *first_snap(N, snaps(N)), tolerance)[1]
    return found
