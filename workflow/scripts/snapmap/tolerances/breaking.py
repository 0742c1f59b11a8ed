"""The largest stress of devices as made under the required shocks."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ..motion.history import extremes_of
from ..study import Study
from .batch import Batch

FOLLOWED, FEWEST = 256, 32
"""So many cells are followed for their stress, each in half a second; or those of at least so many
samples."""


def largest_stresses(
    some: Batch, study: Study, requirements: Sequence[Mapping], C: np.ndarray
) -> np.ndarray:
    """Follow the first samples that have a second shape; (requirements, samples, C), MPa."""
    size = min(some.size, max(FEWEST, FOLLOWED // (len(requirements) * len(C))))
    stress = np.empty((len(requirements), size, len(C)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # how far the mass of each flies
        for place in product(*map(range, stress.shape)):
            asked, i, damping = requirements[place[0]], place[1], C[place[2]]
            pushed = replace(study, device=some.model.device.pick(i), shocks=asked["shocks"])
            factor = {key: values[i] for key, values in some.factors.items()}
            shock = asked["N"] * factor["N"], asked["f0"] / factor["duration"]
            stress[place] = extremes_of(pushed, *shock, damping * factor["C"]).stress_max
    return stress
