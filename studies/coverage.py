"""The share of thresholds of random devices within their error bars, for docs/accuracy.md.

./run python -m studies coverage [--small]

For devices under a versed sine, and for `auto` for devices with gaps, stops and stress, at other
temperatures, of other shapes and free to tilt, under pulses of all shapes in both directions, also
slow ones. Frequencies that take the judges too many steps are left out, and counted.
"""

from time import process_time

import numpy as np

from snapmap import Study, threshold
from snapmap.device.device import Device
from snapmap.pulse.shocks import HANDOUT_SHOCK, Shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines, Elements
from snapmap.solver.settings import Run
from snapmap.thresholds.effort import CLOSE_STEP
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import Timed, few, number
from .random_devices import (
    FREQUENCIES,
    SLOWEST,
    draw_device,
    draw_pulse,
    draw_shocks,
    draw_widest_device,
)
from .tables import Table, write

SEED, DEVICES, DEVICES_OF_ALL = 53, 24, 24
KEYS = "N_first", "N_error", "ragged"
MODELS = {"auto": Auto(), "5 elements": Elements(), "5 cosines": Cosines(modes=5)}
JUDGES = Cosines(modes=16), Elements(elements=20, modes=12)
JUDGED_STEP = 0.2
"""The judges are two far finer discretisations in a fifth of the default steps. A threshold on
which they agree is well posed."""
MOST_STEPS = 3e5
"""Largest number of steps of a judge's run; rows that need more are left out. Only pulses with
corners need as many, across gaps or between stops."""
AGREED, REFINED = 3e-4, 1e-5
"""Largest difference between judges that agree, and tolerance of their thresholds; relative."""
REACHES, WIDTH = (1.01, 1.1), 2 * CLOSE_STEP
"""Factors on a threshold within which the judges search in turn, and the width of the stretches
that they see, as wide as `threshold` promises to see."""
HORIZON = 1500.0
HEAD = ["devices", "model", "thresholds", "known", "within the error"]
HEAD += ["clean and known", "within the error"]
HEAD += ["largest, over the error", "median error bar, %", "s per threshold", "too slow", "refused"]


def main():
    versed = judge_devices(few(DEVICES, 2), MODELS)
    of_all = judge_devices(few(DEVICES_OF_ALL, 2), few(MODELS), of_all=True)
    rows = [[f"{few(DEVICES, 2)}, versed sine", *row] for row in versed]
    rows += [[f"{few(DEVICES_OF_ALL, 2)} of all features", *row] for row in of_all]
    write("coverage", Table("coverage", HEAD, rows))


def judge_devices(count, models, of_all: bool = False):
    """Draw devices and judge their thresholds; yields a row for each model."""
    draw, long = np.random.default_rng(SEED), []
    judged = {name: [] for name in models}
    for _ in range(count):
        device, shocks, f0, C, is_long = draw_rows(draw, of_all)
        long += [*is_long] * len(C)
        f0 = f0[~is_long]
        if not f0.size:
            continue
        runs = {name: ask(device, f0, C, chosen, shocks) for name, chosen in models.items()}
        about = next(run.result[0] for run in runs.values() if run.result)
        truth = judge(device, f0, C, about, shocks)
        for name, run in runs.items():
            judged[name].append((run, truth))
    for name, runs in judged.items():
        yield [name, *summary(runs, int(np.sum(long)))]


def draw_rows(draw: np.random.Generator, of_all: bool = False) -> tuple:
    """Draw a device, shocks, f0 (Hz), C (uN us/um), and a mask of the f0 that need MOST_STEPS."""
    device = draw_widest_device(draw) if of_all else draw_device(draw)
    shocks = draw_pulse(draw) if of_all else HANDOUT_SHOCK
    slowest = SLOWEST if of_all else FREQUENCIES[0]
    f0, C = (np.array(few(a)) for a in draw_shocks(draw, device, (slowest, FREQUENCIES[1])))
    model = build_model(device, JUDGES[0]).with_step(JUDGED_STEP)
    cells = to_rows(0, f0, 0.0, 0, shocks.pulses).cells(device, 1.0, HORIZON).flat()
    steps = cells.t_end / model.time_steps(cells, Run().but(until="edge"))
    return device, shocks, f0, C, steps > MOST_STEPS


def is_clean(run: Timed) -> np.ndarray:
    """Return a mask of the rows that have a threshold and are not ragged, (thresholds,)."""
    N, _, ragged = run.result
    return np.isfinite(N) & (ragged == 0)


def ask(device: Device, f0, C, chosen, shocks: Shocks = HANDOUT_SHOCK) -> Timed:
    """Find N_first, N_error and ragged, (thresholds,), or None after a ValueError."""
    study = Study(device, chosen, horizon=HORIZON).under(shocks)
    begin = process_time()
    try:
        answer = threshold(study, f0, C)
        answer = tuple(answer[key].values.ravel() for key in KEYS)
    except ValueError as error:
        print(f"{device}: {error}")
        answer = None
    return Timed(answer, process_time() - begin)


def judge(device: Device, f0, C, about, shocks: Shocks = HANDOUT_SHOCK) -> np.ndarray:
    """Find the thresholds on which the judges agree, (thresholds,), else NaN.

    about: thresholds near which they search
    """
    rows = to_rows(0, np.tile(f0, len(C)), np.repeat(C, len(f0)), 0, shocks.pulses)
    settings = Run(horizon=HORIZON)
    judges = [build_model(device, chosen).with_step(JUDGED_STEP) for chosen in JUDGES]
    by_judge = [look(Probe(model, rows, settings), about) for model in judges]
    mean = np.mean(by_judge, axis=0)
    return np.where(np.ptp(by_judge, axis=0) <= AGREED * mean, mean, np.nan)


def look(probe: Probe, about: np.ndarray) -> np.ndarray:
    """Find thresholds by one judge, (thresholds,); NaN if there is none within REACHES."""
    N = np.full(about.size, np.nan)
    for reach in REACHES:
        left = np.flatnonzero(np.isnan(N))
        bracket = about[left] / reach, about[left] * reach
        N[left] = lowest_snap(probe.take(left), bracket, REFINED, WIDTH)
    return N


def ratios(runs, of_clean: bool = False) -> np.ndarray:
    """Return errors of well-posed thresholds over their bars; inf for a missing threshold.

    of_clean: whether only rows that are not ragged count
    """
    each = []
    for run, truth in runs:
        if run.result is not None:
            known = np.isfinite(truth) & (is_clean(run) if of_clean else True)
            N, bar = (values[known] for values in run.result[:2])
            each.append(np.nan_to_num(abs(N - truth[known]) / bar, nan=np.inf))
    return np.concatenate(each)


def summary(runs, slow: int):
    """Write the cells of a row of the table; slow: number of rows that are left out."""
    over, clean = ratios(runs), ratios(runs, of_clean=True)
    size = sum(truth.size for _, truth in runs)
    bars = np.concatenate([run.result[1] / run.result[0] for run, _ in runs if run.result])
    return [
        str(size + slow),
        *(str(count) for count in (over.size, np.sum(over <= 1), clean.size, np.sum(clean <= 1))),
        f"{clean.max(initial=0):.2f}",
        number(100 * np.nanmedian(bars)),
        number(sum(run.seconds for run, _ in runs) / size),
        str(slow),
        str(sum(run.result is None for run, _ in runs)),
    ]
