"""Ends of damped beams over the time step and the number of cosines, for docs/accuracy.md.

./run python -m studies ends [--small]
"""

import math
import warnings
from dataclasses import replace
from time import process_time

import numpy as np

from snapmap import Study, threshold
from snapmap.beam.modal import natural_frequency
from snapmap.device.device import batch
from snapmap.solver.adaptive import build_adaptive
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import side_at_end
from snapmap.solver.settings import EDGE, SNAP, STAY, Run

from .common import few, number, with_beam
from .random_devices import draw_device, even
from .tables import Table, write

SEED, DEVICES = 11, 24
LANDINGS = {
    "soft": lambda device, draw: replace(
        device, contact=192 * device.beam.stiffness_unit * even(draw, 0.1, 100.0)
    ),
    "hard": lambda device, draw: replace(device, contact=math.inf),
    "gap": lambda device, draw: replace(device, gap=device.beam.rise * even(draw, 0.03, 3.0)),
    "stops": lambda device, draw: replace(
        device,
        stop_away=device.beam.rise * even(draw, 0.1, 3.0),
        stop_toward=device.beam.rise * even(draw, 1.6, 4.0),
        restitution=draw.uniform(0.0, 0.9),
    ),
}
"""Devices by what their mass meets, in turns."""
FACTORS = np.geomspace(1.1, 5.0, 14)
"""N over the threshold."""
STRONG = 2.0
"""N over the threshold from which shocks are called strong."""
SHAPES = "half sine", "versed sine", "sawtooth", "trapezoid"
JUDGES = (11, 1.0), (17, 0.7)
"""Numbers of cosines and steps, as in RULES, of runs that take the steps of STAY from the start."""
AUTO = "auto"
RULES = [(cosines, step) for cosines in (3, 5, 11) for step in (4.0, 2.0, 1.0)] + [(AUTO, 1.0)]
"""Number of cosines, or the model AUTO, and step over the default one for the question STAY."""
LONGEST_RUN = 2e4
"""Longest pulse and horizon, us, over the thickness of the beam, um."""


def main():
    warnings.simplefilter("ignore")
    write("ends", Table("ends", [*HEAD], [*rows()]))


HEAD = "cosines", "step over the default", *LANDINGS, f"below {STRONG:g} N_first", "above", "all"
HEAD += ("known", "CPU, s")


def rows():
    """Yield rows of the share of judged ends that each rule gets wrong, and of its CPU time."""
    draw, cases = np.random.default_rng(SEED), []
    while len(cases) < few(DEVICES, 2):
        case = draw_case(draw, [*LANDINGS][len(cases) % len(LANDINGS)])
        if case is not None:
            cases.append(case)
    first, second = (ends(cases, *judge, snap_too=True)[0] for judge in JUDGES)
    same = (first == second) & (first > 0)
    alike = first[:, 1:] == first[:, :-1]
    judged = same.copy()
    judged[:, 1:] &= same[:, :-1] & alike
    judged[:, :-1] &= same[:, 1:] & alike
    strong = np.broadcast_to(FACTORS > STRONG, same.shape)
    kinds = np.arange(len(cases))[:, np.newaxis] % len(LANDINGS)
    parts = [np.broadcast_to(kinds == i, same.shape) for i in range(len(LANDINGS))]
    for cosines, step in RULES:
        found, seconds = ends(cases, cosines, step)
        wrong = [
            f"{np.mean((found != first)[part & judged]):.1%}"
            for part in (*parts, ~strong, strong, np.ones_like(strong))
        ]
        yield [str(cosines), f"{step:g}", *wrong, str(judged.sum()), number(seconds)]


def draw_case(draw, kind):
    """Draw a damped device and a shock: device, pulse, f0 (Hz), C, N and horizon; None for none."""
    device = LANDINGS[kind](draw_device(draw), draw)
    device = with_beam(device, damping=natural_frequency(device.beam) / even(draw, 3.0, 300.0))
    C = math.sqrt(device.spring * device.mass) * even(draw, 0.05, 0.8)
    f0 = device.own_frequency / (2 * math.pi) * 1e6 * even(draw, 0.1, 6.0)
    shape, direction = str(draw.choice(SHAPES)), str(draw.choice(["+z", "+z", "-z"]))
    longest = LONGEST_RUN * device.beam.thickness
    horizon = min(8 / device.beam.damping + 8 * device.mass / C, longest)
    study = Study(device, pulse=shape, direction=direction, horizon=horizon)
    N = threshold(study, [f0], [C]).N_first.item() if 1e6 / f0 < longest else math.nan
    return (device, study.shocks.pulses, f0, C, N, horizon) if math.isfinite(N) else None


def ends(cases, cosines, step, snap_too=False):
    """Follow all cases by a rule: sides of the saddle at the end, (cases, N), and CPU time, s.

    snap_too: whether the steps of STAY are those up to the snap, too
    """
    sides, seconds = [], 0.0
    for device, pulses, f0, C, N, horizon in cases:
        if cosines == AUTO:
            model = build_adaptive(batch([device]))
            follow = model.follow_ends
        else:
            model = build_model(batch([device]), Cosines(modes=cosines))
            follow = with_stay(model, step, snap_too).follow
        cells = to_cells(model.device, 0, N * FACTORS, f0, C, horizon, 0, pulses)
        settings = Run(horizon=horizon).but(until="end")
        follow(cells.take(np.zeros(0, int)), settings)  # compiles
        begin = process_time()
        run = follow(cells, settings)
        seconds += process_time() - begin
        sides.append(np.where(np.isfinite(run.t_snap), side_at_end(run, 1e-3), 0))
    return np.array(sides), seconds


def with_stay(model, step, snap_too):
    """Multiply the longest step for STAY, which may be that for the other questions, too."""
    steps, stay = model.steps, step * model.steps.longest[STAY]
    longest = dict(steps.longest) | {STAY: stay}
    if snap_too:
        longest |= {SNAP: stay, EDGE: stay}
        steps = replace(steps, shortest=stay, pressed=stay, most=np.inf * steps.most)
    return replace(model, steps=replace(steps, longest=longest))
