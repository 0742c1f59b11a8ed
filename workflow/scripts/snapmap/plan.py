"""The plan of a study: its grid cut into slabs, and what the job of each may cost."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from .config import Study
from .models import RUNGS, Model, build_model, check_options
from .partition import Slab

JOB_SECONDS = 30
"""At most the expected time of a slab, most take over a third: long against a job's start, and
short enough to lose."""
MOST_SECONDS, MOST_CELLS, MOST_DAMPINGS = 3.6e7, 10**10, 1000
"""Grids beyond are taken for a slip: 10 000 core hours, 10^10 cells, 1000 maps."""
START_MB, CELL_MB = 1000, 5e-4
"""Asked for a job's start and for each cell; seen: 700 MB, two Snakemakes among them, and 200 B."""
START_MINUTES, CAUTION = 2, 20
"""Asked for a job's start, and times the expected time; seen: 15 s, and 3 to 9 times."""


class Request(NamedTuple):
    """What a job asks of a cluster; memory in MB, run time in minutes."""

    mem_mb: int
    runtime: int


def cut(study: Study) -> list[Slab]:
    """Cut the grid into slabs of one C each, along boundaries that no other value moves.

    Raises ValueError, one line, for a model that cannot be built and a grid beyond all reason.
    """
    _check_size(study)
    model = _cheapest(study)
    seconds = _seconds(model, 1e6 / study.f0 + study.protocol.horizon)
    _check_cost(study, model, seconds.sum() * study.N.size * study.C.size)
    by_f0 = dict(zip(study.f0.tolist(), seconds.tolist(), strict=True))
    # `auto` looks at neighbours along N: they stay together.
    boxes = _boxes(study.f0, study.N, by_f0, study.model["name"] != "auto")
    planes = [(tuple(f0.tolist()), tuple(N.tolist())) for f0, N in boxes]
    return [Slab((C,), f0, N) for C in study.C.tolist() for f0, N in planes]


def _boxes(f0, N, seconds, cuts_N):
    """Halve the (f0, N) plane, octaves first, until no box takes more than JOB_SECONDS.

    The halves are those of a fixed binary tree over all floating-point numbers, so that a grid
    that grows keeps every box without a new value.
    """
    level_f0, level_N = _level(f0), _level(N) if cuts_N else 0
    expected = N.size * sum(seconds[value] for value in f0.tolist())
    if expected <= JOB_SECONDS or not level_f0 + level_N:
        return [(f0, N)]
    if level_f0 >= level_N:
        halves = [(half, N) for half in _halves(f0, level_f0)]
    else:
        halves = [(f0, half) for half in _halves(N, level_N)]
    return [box for half in halves for box in _boxes(*half, seconds, cuts_N)]


def _level(ascending):
    """The highest bit in which the numbers differ, counted from 1; 0 for a single number."""
    bits = ascending.view(np.uint64)
    return int(bits[0] ^ bits[-1]).bit_length()


def _halves(ascending, level):
    upper = (ascending.view(np.uint64) >> np.uint64(level - 1)) & np.uint64(1) == 1
    return ascending[~upper], ascending[upper]


def _check_size(study):
    cells = study.C.size * study.f0.size * study.N.size
    if cells > MOST_CELLS:
        need = f"more than {MOST_CELLS:.0e}; write fewer points"
        raise ValueError(f"sweep: {cells:.3g} cells, {need}")
    if study.C.size > MOST_DAMPINGS:
        need = f"at most {MOST_DAMPINGS}, as each gets a map"
        raise ValueError(f"sweep.C: {study.C.size} values; write {need}")


def _check_cost(study, model, seconds):
    longest = [_seconds(model, 1e6 / cell.f0 + study.protocol.horizon) for cell in study.histories]
    if seconds + sum(longest) > MOST_SECONDS:
        hours = f"{(seconds + sum(longest)) / 3600:.2g} core hours"
        raise ValueError(
            f"sweep: up to {hours} from f0 = {study.f0[0]:g} Hz with horizon "
            f"{study.protocol.horizon:g} us and steps of {model.dt:.2g} us, more than "
            f"{MOST_SECONDS / 3600:g}; write fewer points, a higher f0 or a shorter horizon"
        )


def _cheapest(study):
    """The model that follows every cell; its options are checked."""
    if study.model["name"] != "auto":
        return build_model(study.device, **study.model)
    options = {key: value for key, value in study.model.items() if key != "name"}
    check_options(study.device, "auto", options)
    return build_model(study.device, "cosines", modes=RUNGS[0])


def _seconds(model: Model, duration):
    """Expected time of one cell followed once for `duration` us, to share out work by."""
    modes = model.modal.load.size
    nanoseconds = 80 if model.name == "reference" else 1 + modes**2 / 20
    return duration / model.dt * nanoseconds * 1e-9


def requests(study: Study, slabs: Mapping[str, Slab]) -> dict[str, Request]:
    """Ask for memory and time, with room to spare, for the job of each named slab."""
    model = _cheapest(study)
    return {name: _request(model, study.protocol, slab) for name, slab in slabs.items()}


def _request(model, protocol, slab):
    cells = len(slab.C) * len(slab.f0) * len(slab.N)
    mean = _seconds(model, 1e6 / np.array(slab.f0) + protocol.horizon).mean()
    minutes = START_MINUTES + CAUTION * cells * mean / 60
    return Request(int(START_MB + CELL_MB * cells), int(np.ceil(minutes)))
