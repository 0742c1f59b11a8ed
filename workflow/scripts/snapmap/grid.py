"""A grid of cells over (C, f0, N): followed, and labelled."""

from collections.abc import Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .device import Device
from .models import Model
from .outcome import label
from .protocol import Protocol

AXES = ("C", "f0", "N")
REPEATED_STEP = 0.75
"""The second run of a cell takes this fraction of the first one's step."""


def follow_grid(
    device: Device,
    model: Model,
    axes: Sequence[Sequence[float]],
    protocol: Protocol,
    threads: int = 1,
) -> dict[str, np.ndarray]:
    """Follow every cell of a grid; returns each variable of a cube as an array (C, f0, N).

    axes: values of C (uN us/um), f0 (Hz) and N (multiples of g)
    """
    C, f0, N = (values.ravel() for values in np.meshgrid(*axes, indexing="ij"))
    cells = to_cells(device, N, f0, C, protocol.horizon)
    facts = follow_cells(device, model, cells, protocol, threads)
    variables = {
        "outcome": label(*facts, protocol.energy_tolerance),
        "t_snap": facts.t_snap,
        "t_settled": facts.t_settled,
        "energy_error": facts.energy_error,
    }
    if protocol.repeat:
        other = model._replace(dt=REPEATED_STEP * model.dt)
        again = follow_cells(device, other, cells, protocol, threads)
        same = label(*again, protocol.energy_tolerance) == variables["outcome"]
        variables["reproduced"] = same.astype(np.int8)
    shape = [len(values) for values in axes]
    return {key: values.reshape(shape) for key, values in variables.items()}
