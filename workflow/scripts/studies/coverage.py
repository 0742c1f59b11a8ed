"""How many thresholds of random devices lie within their error bars: docs/thresholds.md.

PYTHONPATH=workflow/scripts ./run python -m studies.coverage [devices] [any] [--small]

With `any`, devices with gaps and stress, free to tilt, under all shapes and along both directions.

Writes results/figures/coverage.pdf and .png: errors over their bars, by model.
"""

import sys
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from snapmap import threshold
from snapmap.device import Device
from snapmap.io.markdown import number, table
from snapmap.pulse import HANDOUT_SHOCK, Shocks
from snapmap.solver.bracket import lowest_snap
from snapmap.solver.cells import Rows, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.islands import FOUND, NOT_FOLLOWED, NOTHING_SNAPS

from .few import SMALL, few
from .random_devices import draw_any_device, draw_device, draw_pulse, draw_shocks

SEED, DEVICES, THREADS = 13, 24, 2


class Run(NamedTuple):
    """What a model answered, or None after an exception, and the time that it took, s."""

    result: tuple | None
    seconds: float


MODELS = {
    "auto": {"model": "auto"},
    "handout": {"model": "handout"},
    "5 cosines": {"model": "cosines", "modes": 5},
}
JUDGES = (
    {"name": "cosines", "modes": 16},
    {"name": "elements", "elements": 20, "modes": 12},
)
JUDGED_STEP = 0.2
"""Two discretisations, far finer than what is judged, in a fifth of its steps; what they agree on
is well posed."""
AGREED, REFINED = 3e-4, 1e-5
REACHES, CLOSE = (1.01, 1.1), 0.002
"""About a threshold found before, the judges look this far around it in turn, in such steps."""
HORIZON = 1500.0
HEAD = [
    "model",
    "well posed",
    "within the bar",
    "share",
    "missed",
    "nothing snaps",
    "not followed",
    "NaN without a reason",
    "failed",
    "s per threshold",
    "bar",
]


def main():
    given = [word for word in sys.argv[1:] if word not in (SMALL, "any")]
    count, of_all = few(int(given[0]) if given else DEVICES), "any" in sys.argv[1:]
    draw = np.random.default_rng(SEED)
    found = {name: [] for name in MODELS}
    for _ in range(count):
        device = draw_any_device(draw) if of_all else draw_device(draw)
        shocks = draw_pulse(draw) if of_all else HANDOUT_SHOCK
        f0, C = (few(values) for values in draw_shocks(draw, device))
        runs = {name: ask(device, f0, C, options, shocks) for name, options in MODELS.items()}
        about = next(run.result[0] for run in runs.values() if run.result)
        truth = judge(device, f0, C, about, shocks)
        for name, run in runs.items():
            found[name].append((run, truth))
    print(f"{count} devices, {count * len(f0) * len(C)} thresholds\n")
    print(table(HEAD, [[name, *summary(runs)] for name, runs in found.items()]))
    draw_errors(found)


def ask(device: Device, f0, C, options, shocks: Shocks = HANDOUT_SHOCK) -> Run:
    """N_first, N_error and status, (thresholds,), or None after an exception; the time taken."""
    asked = {"pulse": shocks.pulse, "direction": shocks.direction, "threads": THREADS}
    begin = perf_counter()
    try:
        answer = threshold(device, f0, C, horizon=HORIZON, **asked, **options)
        answer = tuple(answer[key].values.ravel() for key in ("N_first", "N_error", "status"))
    except ValueError as error:
        print(f"{device}: {error}")
        answer = None
    return Run(answer, perf_counter() - begin)


def judge(device: Device, f0, C, about, shocks: Shocks = HANDOUT_SHOCK) -> np.ndarray:
    """Thresholds, (thresholds,), NaN where the judges do not agree, or one finds none."""
    rows = to_rows(0, np.tile(f0, len(C)), np.repeat(C, len(f0)))
    settings = Settings(HORIZON, threads=THREADS, pulses=shocks.pulses)
    judges = [build_model(device, **options).with_step(JUDGED_STEP) for options in JUDGES]
    by_judge = [look(model, rows, about, settings) for model in judges]
    mean = np.mean(by_judge, axis=0)
    return np.where(np.ptp(by_judge, axis=0) <= AGREED * mean, mean, np.nan)


def look(model, rows: Rows, about, settings: Settings) -> np.ndarray:
    """Thresholds by one judge, (thresholds,); NaN where there is none within REACHES."""
    found = np.full(about.size, np.nan)
    for reach in REACHES:
        left = np.flatnonzero(np.isnan(found))
        bracket = about[left] / reach, about[left] * reach
        found[left] = lowest_snap(model, rows.some(left), bracket, settings, REFINED, CLOSE)
    return found


def ratios(runs) -> np.ndarray:
    """Errors over their bars where the threshold is well posed; inf where none was found."""
    each = []
    for run, truth in runs:
        known = np.isfinite(truth)
        if run.result is not None:
            N, bar, _ = (values[known] for values in run.result)
            each.append(np.nan_to_num(abs(N - truth[known]) / bar, nan=np.inf))
    return np.concatenate(each)


def summary(runs):
    """A row of the table."""
    over = ratios(runs)
    asked = sum(truth.size for _, truth in runs)
    N, status = (np.concatenate([run.result[i] for run, _ in runs if run.result]) for i in (0, 2))
    bars = np.concatenate([run.result[1] / run.result[0] for run, _ in runs if run.result])
    return [
        str(over.size),
        str(np.sum(over <= 1)),
        f"{np.mean(over <= 1):.1%}",
        str(np.sum(np.isinf(over))),
        *(str(np.sum(status == reason)) for reason in (NOTHING_SNAPS, NOT_FOLLOWED)),
        str(np.sum(np.isnan(N) & (status == FOUND))),
        str(sum(run.result is None for run, _ in runs)),
        number(sum(run.seconds for run, _ in runs) / asked),
        f"{np.nanmedian(bars):.2%}",
    ]


def draw_errors(found):
    """Draw the share of thresholds whose error is at most so many bars."""
    figure = Figure(figsize=(3.4, 2.6), layout="constrained")
    ax = figure.subplots()
    for name, runs in found.items():
        over = np.sort(ratios(runs))
        ax.step(over, np.arange(1, over.size + 1) / over.size, where="post", label=name)
    ax.axvline(1, color="0.6", linewidth=0.8)
    ax.set(xscale="log", xlim=(1e-3, 10), ylim=(0, 1.02))
    ax.set(xlabel="error over error bar", ylabel="share of the thresholds")
    ax.legend(frameon=False)
    folder = Path("results") / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    for kind in ("pdf", "png"):
        figure.savefig(folder / f"coverage.{kind}", dpi=200)


if __name__ == "__main__":
    main()
