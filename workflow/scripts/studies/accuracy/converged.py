"""Converged runs, their own error as refinement shows it, and what they know well enough."""

from typing import NamedTuple

import numpy as np

from snapmap.device import Device
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings

from .answers import TOLERANCE, Answer, ask, follow_map
from .plans import Refinement
from .probe import Probe

DECIDED = 1e-3
"""A converged value faults no case unless its own relative error is below this."""
FINE_STEP = 0.2
"""Step of the converged runs, as a fraction of the stability limit."""
# ASSUME: central differences are of order 2; kept modes were never seen to converge more slowly.
ORDER, MESH_ORDER = 2, 4
SAFETY = 2.0
"""An own error is so many times what Richardson's formula leaves after a refinement."""


class Converged(NamedTuple):
    """A converged run and its own error; the same of another discretisation, NaN if not planned.

    clean: whether labels change once along N, (rows,)
    error, other, other_error: as `Answer.values`
    repeated: t_snap of the map with twice the step
    """

    answer: Answer
    clean: np.ndarray
    error: np.ndarray
    other: np.ndarray
    other_error: np.ndarray
    repeated: np.ndarray


def converge(device: Device, probe: Probe, settings: Settings, refinement: Refinement) -> Converged:
    """Ask many cosines, in fine steps, and as many elements, and estimate what is left of error."""

    def refined(name, modes, step=FINE_STEP, **options):
        model = build_model(device, name, modes=modes, step=step, **options)
        return ask(model, probe, settings)

    fine, error = _refine(refined, "cosines", *refinement.cosines)
    other, other_error = np.full((2, *fine.shape), np.nan)
    if refinement.meshes:
        other, other_error = _refine_elements(refined, refinement)
    model = build_model(device, "cosines", modes=refinement.cosines[0], step=FINE_STEP)
    found = Answer(fine, *follow_map(model, probe, settings))
    repeated, _ = follow_map(model.with_step(2), probe, settings)
    return Converged(found, probe.clean, error, other, other_error, repeated)


def _refine(refined, name, many, fewer, **options):
    """Values with many modes, and their own error by fewer and by twice the step."""
    fine = refined(name, many, **options)
    by_modes = _remainder(fine, refined(name, fewer, **options), many / fewer, ORDER)
    by_step = _remainder(fine, refined(name, many, 2 * FINE_STEP, **options), 2, ORDER)
    return fine, SAFETY * (np.abs(by_modes) + np.abs(by_step)) + TOLERANCE * fine


def _refine_elements(refined, refinement):
    """The same of elements, with Richardson's value from two meshes."""
    fine_mesh, coarse_mesh = refinement.meshes
    fine, error = _refine(refined, "elements", *refinement.modes, elements=fine_mesh)
    coarse = refined("elements", refinement.modes[0], elements=coarse_mesh)
    added = _remainder(fine, coarse, fine_mesh / coarse_mesh, MESH_ORDER)
    return fine + added, error + np.abs(added)


def _remainder(fine, coarse, ratio, order):
    """What Richardson's formula adds to `fine`, found with `ratio` times the resolution."""
    return (fine - coarse) / (ratio**order - 1)


def gap(run: Converged) -> float:
    """Largest difference of the two discretisations over the sum of their own errors; NaN for none.

    They agree if it is at most 1. Only what is decided counts.
    """
    apart = np.abs(run.answer.values - run.other) / (run.error + run.other_error)
    return float(np.max(apart[decided(run)], initial=0.0))


def decided(run: Converged) -> np.ndarray:
    """Where the converged values are known well enough to fault others, (2, rows).

    No snap is timed above a threshold that is not known.
    """
    return np.logical_and.accumulate(run.clean & (run.error < DECIDED * run.answer.values))
