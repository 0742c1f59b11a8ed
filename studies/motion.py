"""The motion after the snap by models and steps, and errors of histories, for docs/accuracy.md.

./run python -m studies motion [--small]
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from snapmap import load_device
from snapmap.applications.histories.history import errors_of
from snapmap.applications.histories.motion import record
from snapmap.beam.limit_loads import static_threshold
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.outcome import REPEATED_STEP, t_snap_error, work_error
from snapmap.solver.settings import MOVE, Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import ROOT, few, number, stepped
from .random_devices import draw_pulse, draw_shocks, draw_widest_device, even
from .tables import Table, write

N, F0, C = np.linspace(1100, 3000, 4), np.geomspace(1e3, 8e3, 4), 25.0
CONTACTS = (40.0, np.inf)
MODELS = {"5 cosines": Cosines(modes=5), "7 cosines": Cosines(modes=7), "5 elements": Elements()}
FINEST, FINE, OTHER = "7 cosines", 0.002, 0.003
"""Name of the reference, its step, and another step that shows its error, us."""
SETTINGS = Run(horizon=1000.0)
HEAD = ["contact, N/m", "model", "step, us", "work: median, %", "largest, %", "t_snap, us"]
HEAD += ["highest z, um", "reported: median, %", "largest, %"]

SEED, DEVICES, JUDGED_STEP = 53, 16, 0.25
"""Random devices, and the step of the runs that judge the errors of histories, over their own."""
OF_HISTORIES = {"5 cosines": 5, "11 cosines, without free beams": 11}
REACHES, COARSE, CLOSE = (0.3, 3e3), 0.1, 2e-3
"""Where the threshold is sought, over the static one, in which steps, and how closely."""
ABOVE, MOST_STEPS = (0.005, 1.5), 2e5
"""N of the histories above the threshold, relative, and the most steps that these may take."""
TINY = 1e-9
"""Error of a snap that all runs see at the same time, us."""
JUDGED = ["model", "devices", "histories", "work within its error", "snap within its error"]
JUDGED += ["snap's error / reported: median", "90 %", "not all steps snap"]


class Moved(NamedTuple):
    """Work of the pulse, pJ; snap, us; highest z_M from rest, um; (cells,)."""

    work: np.ndarray
    t_snap: np.ndarray
    highest: np.ndarray


def main():
    device = load_device(ROOT / "config" / "damped.yaml")
    rows = []
    for contact in few(CONTACTS):
        held = replace(device, contact=contact)
        models = {name: build_model(held, chosen) for name, chosen in few(MODELS, 2).items()}
        finest = follow(stepped(models[FINEST], FINE))
        models[FINEST + ", fine"] = stepped(models[FINEST], OTHER)
        for name, model in models.items():
            off = compare(follow(model), finest)
            dt = model.steps.longest[MOVE].item()
            rows.append([f"{contact:g}", name, number(dt), *off, *spread(work_errors(model))])
    of_random = [row for model in few(OF_HISTORIES).items() for row in judge(*model)]
    write("motion", Table("motion", HEAD, rows), Table("motion_errors", JUDGED, of_random))


def cells_of(device):
    """Make the cells of a device, all N at each F0, (cells,)."""
    f0, amplitude = (values.ravel() for values in np.meshgrid(few(F0), N))
    return to_cells(device, 0, amplitude, f0, C, SETTINGS.horizon).take(np.arange(f0.size))


def follow(model):
    """Follow the cells with the default step of the model."""
    cells = cells_of(model.device)
    observed = model.follow_once(cells, SETTINGS.but(until="moved"))
    dt = model.steps.of(cells, MOVE)
    runs = [record(model, cells.take([i]), dt[[i]])[1] for i in range(dt.size)]
    highest = np.array([max(part.y.max() for part in parts) for parts in runs])
    return Moved(observed.pulse_work, observed.t_snap, highest)


def compare(moved, converged):
    """Write the spread of the errors of the work, the median of the snap's, the largest of z's."""
    snap = np.nanmedian(abs(moved.t_snap - converged.t_snap))
    highest = abs(moved.highest - converged.highest).max()
    return [*spread(abs(moved.work / converged.work - 1)), number(snap), number(highest)]


def work_errors(model):
    """Estimate the error of the work of each cell as a cube does, (cells,)."""
    cells, models = cells_of(model.device), (model, model.with_step(REPEATED_STEP))
    return work_error(*(model.follow(cells, SETTINGS) for model in models))


def spread(errors):
    """Write median and largest, in per cent."""
    return [number(100 * value) for value in np.quantile(errors, [0.5, 1.0])]


def judge(name, modes):
    """Write rows of the table of errors of histories, for even and for odd devices."""
    runs = [judged(np.random.default_rng([SEED, n]), modes) for n in range(few(DEVICES, 4))]
    for words, half in (("even", runs[::2]), ("odd", runs[1::2])):
        work, work_bar, snap, snap_bar, snaps = np.concatenate(half, axis=1)
        known, unknown = np.isfinite(snap_bar), np.isnan(snap_bar) & (snaps > 0)
        pairs = (work, work_bar), (snap, snap_bar)
        shares = [np.mean((error <= bar)[known]) for error, bar in pairs]
        over = np.nan_to_num(snap[known], nan=np.inf) / np.fmax(snap_bar[known], TINY)
        over = map(number, np.quantile(over, [0.5, 0.9], method="lower"))
        counts = known.sum(), *(f"{share:.0%}" for share in shares), *over
        yield [name, words, *map(str, counts), str(unknown.sum())]


def judged(draw, modes):
    """Errors of histories of a random device above its thresholds, (5, cells).

    Of the work, relative, that against a run in JUDGED_STEP and the reported one; both of the snap,
    us; and whether the history snaps.
    """
    device, shocks = draw_widest_device(draw), draw_pulse(draw)
    f0, C = np.meshgrid(*draw_shocks(draw, device))
    if device.beam.free and modes > 5:
        return np.empty((5, 0))
    settings = Run(horizon=2 * np.pi / device.own_frequency, repeat=False).but(until="moved")
    model, rows = build_model(device, Cosines(modes=modes)), to_rows(0, f0, C, 0, shocks.pulses)
    bracket = tuple(reach * float(static_threshold(device)) for reach in REACHES)
    found = lowest_snap(Probe(model, rows, settings), bracket, CLOSE, COARSE)
    N = found * [1 + even(draw, *ABOVE) for _ in found]
    known = np.isfinite(N)
    cells = rows.take(known).cells(device, N[known, np.newaxis], settings.horizon).flat()
    cells = cells.take(np.flatnonzero(cells.t_end / model.time_steps(cells, settings) < MOST_STEPS))
    own, finer = (model.with_step(step).follow_once(cells, settings) for step in (1, JUDGED_STEP))
    bars, snaps = errors_of(model, cells, settings), np.isfinite(own.t_snap)
    work, snap = (compare(own, finer) for compare in (work_error, t_snap_error))
    return np.array([work, bars["work_error"], snap, bars["t_snap_error"], snaps])
