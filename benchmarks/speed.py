"""Workload A, followed by everyone."""

from functools import partial

from contenders import REFERENCE, heyokas, scipys
from kernel import step_flops
from peers import TOLERANCE
from timing import take_turns
from workload import (
    FEWEST,
    SETTINGS,
    SIDE,
    by_model,
    count_steps,
    map_cells,
    same_labels,
    without_proofs,
)

from snapmap.device import Device
from snapmap.io.markdown import DASH, number, rate, ratio, table
from snapmap.solver.models import Model
from studies.few import few

ROUNDS = 5
FEW = slice(4, None, 29)
"""Cells of the map for those too slow for all: nine, strewn over it."""
HEAD = [
    *("", "cells", "sims/s", "to reference", "labels as reference"),
    *("sims/s with proofs", "to reference"),
    *("cells repeated", "ns per lane-step", "GFLOP/s", "of peak"),
]
LEGEND = """
The cells: {side} x {side}, N = 600 to 2400, f0 = 300 Hz to 20 kHz, C = 0.025 uN us/um, contact of
40 N/m, each followed to its snap (w_mid <= w2) or {horizon:g} us past the pulse. Times are the
best of {rounds} rounds in turns (A B C A B C ...), SciPy's of one; ratios are to the reference on
the same cells. *With proofs*, as in a sweep, a cell also ends once it is proven never to snap.
*Repeated* cells are followed again with half the step, as their energy ledger did not close. The
last three columns are of the first pass: all steps to the snap or the horizon, some lanes being
empty in the end.

The peers solve the 9-mode form to a tolerance of {tolerance:g}, SciPy with its right-hand side
compiled by numba, heyoka with contact as an event, all at the settings found fastest. heyoka's own
class for one cell at a time is about 4 % faster than its one lane here.
"""


def speed_section(device: Device, models: dict[str, Model], peak: float) -> str:
    """Everyone's speed; `peak` is that of one core, FLOP/s."""
    cells = map_cells(device)
    rivals = heyokas(device)
    tasks = {(name, "open"): partial(follow, cells) for name, follow in rivals.items()}
    for name, model in models.items():
        tasks |= _model_tasks(name, model, cells)
    take_turns(tasks, 1)  # compiles
    runs = take_turns(tasks, few(ROUNDS))
    plain = runs[REFERENCE, "open"]
    rows = [
        _speed(name, runs[name, "open"], plain) + _kernel(name, model, cells, runs, peak)
        for name, model in models.items()
    ]
    rows += [_speed(name, runs[name, "open"], plain) for name in rivals]
    rows += _slow_rows(device, models[REFERENCE], cells.take(FEW))
    facts = {"horizon": SETTINGS.horizon, "tolerance": TOLERANCE}
    legend = LEGEND.format(side=few(SIDE, FEWEST), rounds=few(ROUNDS), **facts)
    return f"\n## Speed\n\n{table(HEAD, rows)}{legend}"


def _model_tasks(name, model, cells):
    unproven = without_proofs(model)
    return {
        (name, "open"): partial(by_model(unproven), cells),
        (name, "proven"): partial(by_model(model), cells),
        (name, "pass"): partial(unproven.follow_once, cells, SETTINGS),
    }


def _speed(name, run, plain):
    count = run.result.size
    labels = f"{same_labels(run.result, plain.result)}/{count}"
    return [name, str(count), rate(count, run.seconds), ratio(plain.seconds / run.seconds), labels]


def _kernel(name, model, cells, runs, peak):
    proven, first = runs[name, "proven"].seconds, runs[name, "pass"]
    steps = count_steps(model, cells, first.result.t_snap)
    repeated = int((~(first.result.energy_error <= SETTINGS.energy_tolerance)).sum())
    flops = step_flops(model) * steps / first.seconds
    lanes = name != REFERENCE
    return [
        rate(cells.f0.size, proven) if lanes else DASH,
        ratio(runs[REFERENCE, "open"].seconds / proven) if lanes else DASH,
        str(repeated),
        number(1e9 * first.seconds / steps),
        number(flops / 1e9) if lanes else DASH,
        f"{flops / peak:.0%}" if lanes else DASH,
    ]


def _slow_rows(device, reference, cells):
    plain = take_turns({REFERENCE: partial(by_model(reference), cells)}, few(ROUNDS))[REFERENCE]
    tasks = {name: partial(follow, cells) for name, follow in scipys(device).items()}
    return [_speed(name, run, plain) for name, run in take_turns(tasks, 1).items()]
