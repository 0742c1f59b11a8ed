"""Thresholds of a device with other values."""

from collections.abc import Mapping

import numpy as np

from ..device import batch, is_bistable
from ..solver.adaptive import choose_survey
from ..solver.cells import to_rows
from ..solver.settings import THRESHOLD_TOLERANCE
from ..study import Study
from ..thresholds.islands import survey


def thresholds_at(
    study: Study, values: Mapping[str, np.ndarray], f0: float, C: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Thresholds of a study's device with other values, each (n,), and their errors, or NaN.

    values: by name. Returns also where there is a device; (n,).
    """
    size = next(iter(values.values())).size
    there = is_bistable(study.device, values, size)
    found = np.full((2, size), np.nan)
    if there.any():
        some = {key: column[there] for key, column in values.items()}
        varied = batch([study.device]).pick(np.zeros(there.sum(), int)).vary(some)
        models = choose_survey(varied, study.model)
        rows = to_rows(np.arange(len(varied)), f0, C)
        told = survey(models, rows, study.settings, THRESHOLD_TOLERANCE)
        found[:, there] = told.N_first, told.N_error
    return *found, there
