"""What the time steps of the conserving scheme cost in accuracy, by question: docs/accuracy.md.

PYTHONPATH=workflow/scripts ./run python -m studies.steps [--small]
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from snapmap import load_device
from snapmap.beam.equilibria import static_threshold
from snapmap.device import batch
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.bracket import asker, refine
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.repeat import work_error
from snapmap.solver.settings import MOVE, SNAP, STAY, Settings
from snapmap.solver.steps import LONGEST, PER_SWING, SHORTEST
from snapmap.thresholds.islands import first_seen, wide_scan

from .few import few
from .markdown import number, table
from .random_devices import draw_any_device, draw_pulse, draw_shocks

ROOT = Path(__file__).resolve().parents[3]
SEED, DEVICES, COSINES, THREADS = 5, 24, 7, 2
RULES = (
    (2000, 1.0, 0.05),
    (1000, 3.0, 0.1),
    (PER_SWING, 3.0, SHORTEST),
    (PER_SWING, LONGEST[SNAP], SHORTEST),
    (500, LONGEST[SNAP], 0.25),
    (250, 10.0, 0.5),
)
"""Steps in each swing of the pulse; longest and shortest, over the arch's frequency."""
FINE, FINER = (4000, 0.5, 0.03), (8000, 0.25, 0.015)
AGREED, REFINED, NEAR = 2e-4, 2e-6, 1.04
"""Rows in which the fine rules agree so well are judged; thresholds are refined so far, near."""
LONGEST_PULSE = 1e5
"""Pulses of more than so many of the arch's radians are left to the other studies."""
STAYS, MOVES = (0.2, 0.4, LONGEST[STAY], 0.7, 1.0), (0.05, LONGEST[MOVE], 0.2, 0.3)
CONTACTS = (40.0, 400.0, np.inf)


def main():
    warnings.simplefilter("ignore")
    print(table(["steps per swing", "longest", "shortest", *HEAD], snaps()))
    print(table(["contact, N/m", *(f"{turn:g}" for turn in few(STAYS))], stays()))
    head = [f"{turn:g}: median, 95 %, within 2 %" for turn in few(MOVES)]
    print(table(["contact, N/m", *head], moves()))


HEAD = ["rows", "median", "90 %", "largest", "no threshold near"]


def ruled(model, per_swing, longest, shortest):
    """The model with another rule for the question whether it snaps."""
    steps = model.steps
    period = steps.longest[SNAP] / LONGEST[SNAP]
    longest = {**steps.longest, SNAP: longest * period}
    return replace(
        model,
        steps=replace(steps, longest=longest, shortest=shortest * period, per_swing=per_swing),
    )


def turned(model, question, turn):
    """The model with another longest step, over the arch's frequency, for a question."""
    longest = {**model.steps.longest}
    longest[question] = longest[question] * turn / LONGEST[question]
    return replace(model, steps=replace(model.steps, longest=longest))


def snaps():
    """Rows: errors of the thresholds of random devices, by rule."""
    draw, errors = np.random.default_rng(SEED), []
    for _ in range(few(DEVICES)):
        errors.append(errors_of(draw_any_device(draw), draw_pulse(draw), draw))
    for i, rule in enumerate(few(RULES)):
        known = np.concatenate([found[i] for found in errors])
        lost, off = np.isnan(known), abs(known[np.isfinite(known)])
        spread = np.quantile(off, [0.5, 0.9, 1.0]) if off.size else []
        shown = (f"{number(100 * value)} %" for value in spread)
        yield [*(f"{value:g}" for value in rule), str(known.size), *shown, str(np.sum(lost))]


def errors_of(device, shocks, draw):
    """Relative errors of one device's well-posed thresholds, (rules, rows); NaN where none."""
    model = build_model(batch([device]), "cosines", modes=COSINES)
    f0, C = draw_shocks(draw, device)
    arch = LONGEST[SNAP] / model.steps.longest[SNAP].item()
    f0 = [one for one in f0 if 2e-6 * np.pi * one * LONGEST_PULSE > arch] or f0[-1:]
    rows = to_rows(0, np.array(f0), np.array(C)[:, np.newaxis])
    horizon = 4 * 2 * np.pi / device.own_frequency
    settings = Settings(min(horizon, 3e4 / arch), threads=THREADS, pulses=shocks.pulses)

    def ask(rule):
        return asker(ruled(model, *rule), rows, settings)

    wide = wide_scan(model.device, static_threshold(model.device), rows, shocks.pulses)
    bound = least_amplitudes(model, rows, shocks.pulses)
    near = first_seen(ask(RULES[2]), wide, bound)[0]
    fine = threshold_near(ask(FINE), near)
    finer = threshold_near(ask(FINER), fine)
    posed = abs(fine / finer - 1) < AGREED
    known = np.where(posed, finer, np.nan)
    found = [threshold_near(ask(rule), known) / known - 1 for rule in few(RULES)]
    return np.array(found)[:, posed]


def threshold_near(ask, N):
    """The threshold of each row, if it lies near N, (rows,)."""
    low, high = N / NEAR, N * NEAR
    snapped = np.isfinite(ask(np.column_stack([low, high])))
    there = ~snapped[:, 0] & snapped[:, 1]
    return refine(ask, *(np.where(there, end, np.nan) for end in (low, high)), REFINED)[1]


def stays():
    """Rows: share of cells that end in the second shape, by step, for each contact."""
    N, f0 = few(np.linspace(1040, 2400, 70), 8), few(np.geomspace(300, 1.5e4, 36), 4)
    settings = Settings(6000.0, threads=THREADS)
    for contact in few(CONTACTS):
        model = damped(contact, 1e-3)
        cells = to_cells(model.device, 0, N, f0[:, np.newaxis], 25.0, settings.horizon)
        ends = (turned(model, STAY, turn).follow(cells, settings).well for turn in few(STAYS))
        yield [f"{contact:g}", *(f"{np.mean(well == 2):.1%}" for well in ends)]


def moves():
    """Rows: error of the pulse's work, by step, for each contact."""
    N, f0 = few(np.linspace(1100, 3000, 12), 3), few(np.geomspace(1e3, 8e3, 12), 3)
    settings = Settings(1000.0, until="moved", threads=THREADS)
    for contact in few(CONTACTS):
        model = damped(contact)
        cells = to_cells(model.device, 0, N, f0[:, np.newaxis], 25.0, settings.horizon)
        cells = cells.some(np.ones(cells.f0.shape, bool))
        fine = turned(model, MOVE, 0.01).follow_once(cells, settings)
        shown = []
        for turn in few(MOVES):
            off = work_error(fine, turned(model, MOVE, turn).follow_once(cells, settings))
            middle, most = (f"{number(100 * value)} %" for value in np.quantile(off, [0.5, 0.95]))
            shown.append(f"{middle}, {most}, {np.mean(off < 0.02):.0%}")
        yield [f"{contact:g}", *shown]


def damped(contact, damping=4e-3):
    """The model of the handout's device with a contact, N/m, and damping of the beam, 1/us."""
    device = load_device(ROOT / "config" / "config.yaml")
    beam = replace(device.beam, damping=damping)
    return build_model(replace(device, beam=beam, contact=contact), "cosines", modes=COSINES)


if __name__ == "__main__":
    main()
