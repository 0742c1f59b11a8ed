"""The share of thresholds of random devices within their error bars, for docs/accuracy.md.

./run python -m studies coverage [devices] [any] [--small]

With `any`, only `auto` is judged, on devices with gaps, stops and stress, at other temperatures,
of other shapes and free to tilt, under pulses of all shapes in both directions, also slow ones.
Frequencies that take the judges too many steps are left out, and counted.
"""

import sys
from time import perf_counter

import numpy as np

from snapmap import Study, threshold
from snapmap.device.device import Device
from snapmap.files.text import table
from snapmap.pulse.shocks import HANDOUT_SHOCK, Shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines, Elements
from snapmap.solver.settings import Run
from snapmap.thresholds.effort import CLOSE_STEP
from snapmap.thresholds.probe import Probe, lowest_snap
from snapmap.thresholds.survey import FOUND, NOT_FOLLOWED, NOTHING_SNAPS

from .common import SMALL, Timed, few, number
from .random_devices import (
    FREQUENCIES,
    SLOWEST,
    draw_device,
    draw_pulse,
    draw_shocks,
    draw_widest_device,
)

SEED, DEVICES, THREADS = 53, 24, 2
KEYS = "N_first", "N_error", "status", "ragged"
MODELS = {
    "auto": Auto(),
    "5 elements": Elements(),
    "5 cosines": Cosines(modes=5),
}
JUDGES = Cosines(modes=16), Elements(elements=20, modes=12)
JUDGED_STEP = 0.2
"""The judges are two far finer discretisations in a fifth of the default steps. A threshold on
which they agree is well posed."""
MOST_STEPS = 1e6
"""Largest number of steps of a judge's run; rows that need more are left out. Only pulses with
corners need as many, across gaps or between stops. With 3e5, 150 devices take half an hour of a
core."""
AGREED, REFINED = 3e-4, 1e-5
"""Largest difference between judges that agree, and tolerance of their thresholds; relative."""
REACHES, WIDTH = (1.01, 1.1), 2 * CLOSE_STEP
"""Factors on a threshold within which the judges search in turn, and the width of the stretches
that they see, as wide as `threshold` promises to see."""
HORIZON = 1500.0
HEAD = ["model", "well posed", "within the bar", "share", "clean", "within", "largest, bars"]
HEAD += ["missed", "nothing snaps", "not followed", "NaN without a reason", "failed"]
HEAD += ["s per threshold", "bar"]


def main():
    words = [word for word in sys.argv[1:] if word not in (SMALL, "any")]
    count, of_all = few(int(words[0]) if words else DEVICES), "any" in sys.argv[1:]
    models = {"auto": MODELS["auto"]} if of_all else MODELS
    draw, long = np.random.default_rng(SEED), []
    judged = {name: [] for name in models}
    for _ in range(count):
        device, shocks, f0, C, is_long = draw_rows(draw, of_all)
        long += [*is_long]
        f0 = f0[~is_long]
        if not f0.size:
            continue
        runs = {name: ask(device, f0, C, chosen, shocks) for name, chosen in models.items()}
        about = next(run.result[0] for run in runs.values() if run.result)
        truth = judge(device, f0, C, about, shocks)
        for name, run in runs.items():
            judged[name].append((run, truth))
    print(f"{count} devices; {np.sum(long)} of {len(long)} frequencies are too slow to judge\n")
    print(table(HEAD, [[name, *summary(runs)] for name, runs in judged.items()]))


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
    N, _, _, ragged = run.result
    return np.isfinite(N) & (ragged == 0)


def ask(device: Device, f0, C, chosen, shocks: Shocks = HANDOUT_SHOCK) -> Timed:
    """Find N_first, N_error, status and ragged, (thresholds,), or None after a ValueError."""
    study = Study(device, chosen, run=Run(HORIZON, threads=THREADS)).under(shocks)
    begin = perf_counter()
    try:
        answer = threshold(study, f0, C)
        answer = tuple(answer[key].values.ravel() for key in KEYS)
    except ValueError as error:
        print(f"{device}: {error}")
        answer = None
    return Timed(answer, perf_counter() - begin)


def judge(device: Device, f0, C, about, shocks: Shocks = HANDOUT_SHOCK) -> np.ndarray:
    """Find the thresholds on which the judges agree, (thresholds,), else NaN.

    about: thresholds near which they search
    """
    rows = to_rows(0, np.tile(f0, len(C)), np.repeat(C, len(f0)), 0, shocks.pulses)
    settings = Run(HORIZON, threads=THREADS)
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


def summary(runs):
    """Write the cells of a row of the table."""
    over, clean = ratios(runs), ratios(runs, of_clean=True)
    size = sum(truth.size for _, truth in runs)
    N, status = (np.concatenate([run.result[i] for run, _ in runs if run.result]) for i in (0, 2))
    bars = np.concatenate([run.result[1] / run.result[0] for run, _ in runs if run.result])
    return [
        str(over.size),
        str(np.sum(over <= 1)),
        f"{np.mean(over <= 1):.1%}",
        str(clean.size),
        f"{np.mean(clean <= 1):.1%}",
        f"{clean.max(initial=0):.2f}",
        str(np.sum(np.isinf(over))),
        *(str(np.sum(status == reason)) for reason in (NOTHING_SNAPS, NOT_FOLLOWED)),
        str(np.sum(np.isnan(N) & (status == FOUND))),
        str(sum(run.result is None for run, _ in runs)),
        number(sum(run.seconds for run, _ in runs) / size),
        f"{np.nanmedian(bars):.2%}",
    ]


if __name__ == "__main__":
    main()
