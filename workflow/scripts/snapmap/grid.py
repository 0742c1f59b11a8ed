"""A grid of cells over (C, f0, N): followed, and labelled."""

from collections.abc import Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .ladder import Ladder, climb
from .models import Model
from .outcome import label
from .protocol import Protocol

AXES = ("C", "f0", "N")
REPEATED_STEP = 0.75
"""The second run of a cell takes this fraction of the first one's step."""


def follow_grid(
    model: Model | Ladder,
    axes: Sequence[Sequence[float]],
    protocol: Protocol,
    threads: int = 1,
) -> dict[str, np.ndarray]:
    """Follow every cell of a grid; returns each variable of a cube as an array (C, f0, N).

    axes: values of C (uN us/um), f0 (Hz) and N (multiples of g)
    """
    order = np.argsort(axes[2], kind="stable")
    ascending = *axes[:2], np.asarray(axes[2])[order]
    C, f0, N = (values.ravel() for values in np.meshgrid(*ascending, indexing="ij"))
    cells = to_cells(model.device, N, f0, C, protocol.horizon)
    columns = len(axes[0]) * len(axes[1])
    variables = _follow(model, cells, columns, protocol, threads)
    if protocol.repeat:
        other = model.with_step(REPEATED_STEP)
        again = _follow(other, cells, columns, protocol, threads)
        same = again["outcome"] == variables["outcome"]
        variables["reproduced"] = same.astype(np.int8)
    shape = [len(values) for values in axes]
    as_given = np.argsort(order)
    return {key: values.reshape(shape)[..., as_given] for key, values in variables.items()}


def _follow(model, cells, columns, protocol, threads):
    decided = {}
    if isinstance(model, Ladder):
        facts, level, agreed = climb(model, cells, columns, protocol, threads)
        decided = {"level": level, "agreed": agreed}
    else:
        facts = follow_cells(model, cells, protocol, threads)
    return {
        "outcome": label(*facts[:4], protocol.energy_tolerance),
        "t_snap": facts.t_snap,
        "t_settled": facts.t_settled,
        "energy_error": facts.energy_error,
        "halvings": facts.halvings,
        **decided,
    }
