"""Models that take one step for every question."""

from dataclasses import replace

import numpy as np

from snapmap.solver.models import Model
from snapmap.solver.steps import fixed


def stepped(model: Model, dt: float) -> Model:
    """The model of one device with a step of dt, us, whatever its rule says."""
    return replace(model, steps=fixed(np.array([dt])))
