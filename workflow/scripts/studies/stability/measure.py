"""Follow every hard case with every model at many steps."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
import xarray as xr

from snapmap.device import Device

from .cases import CASES, MODELS, Case
from .dataset import dress
from .pairs import measure_pair

STEPS = (0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.05)


def measure(
    device: Device,
    cases: Sequence[Case] = CASES,
    models: Mapping[str, Mapping] = MODELS,
    steps: Sequence[float] = STEPS,
    threads: int = 1,
) -> xr.Dataset:
    """Follow every case with every model at every step, as shares of its stability limit.

    models: name and options of each, by what the dataset calls it
    The variables named default_* hold what a sweep gives: it takes the model's own step, and
    halves it where a ledger does not close.
    """
    pairs = list(product(cases, models.values()))
    with ThreadPoolExecutor(threads) as pool:
        found = list(pool.map(lambda pair: measure_pair(device, *pair, steps), pairs))
    values = {key: np.array([one[key] for one in found]) for key in found[0]}
    return dress(device, cases, models, steps, values)
