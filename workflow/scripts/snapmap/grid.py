"""A grid of cells over (C, f0, N): followed, and labelled."""

from collections.abc import Sequence

import numpy as np

from .cells import follow_cells, to_cells
from .device import Device
from .models import Model
from .outcome import label

AXES = ("C", "f0", "N")


def follow_grid(
    device: Device,
    model: Model,
    axes: Sequence[Sequence[float]],
    horizon: float,
    threads: int = 1,
) -> dict[str, np.ndarray]:
    """Follow every cell of a grid; returns each variable of a cube as an array (C, f0, N).

    axes: values of C (uN us/um), f0 (Hz) and N (multiples of g); horizon: us after the pulse
    """
    C, f0, N = (values.ravel() for values in np.meshgrid(*axes, indexing="ij"))
    facts = follow_cells(device, model, to_cells(device, N, f0, C, horizon), threads)
    variables = {"t_snap": facts.t_snap, "outcome": label(*facts)}
    shape = [len(values) for values in axes]
    return {key: values.reshape(shape) for key, values in variables.items()}
