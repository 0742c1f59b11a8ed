"""What shots tell of unknowns together, and what they do not tell apart."""

from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr

from .likelihood import Likelihood
from .surface import Surface

STEP = 0.02
"""Of a derivative, as a share of the range."""
FLAT = 12.0
"""One over the variance of a place in its range, of which nothing is known but the range."""
UNTOLD = 0.5
"""Of the standard deviation within the range: what is left of it where shots tell little."""


class Information(NamedTuple):
    """Of the unknowns as shares of their ranges, (unknowns, unknowns).

    covariance: with the ranges; slopes: of ln N of each kind, (kinds, unknowns)
    widths: standard deviations along the directions that are told apart, ascending; directions:
        (widths, unknowns), each of length 1
    """

    covariance: np.ndarray
    slopes: np.ndarray
    widths: np.ndarray
    directions: np.ndarray


def information_at(
    place: np.ndarray, surface: Surface, likelihood: Likelihood, spread: float
) -> Information:
    """Fisher's information of shots at a place, shares of the ranges, at a relative spread."""
    steps = STEP * np.eye(place.size)
    above, below = (np.clip(place + way * steps, 0.0, 1.0) for way in (1, -1))
    apart = (above - below).sum(axis=1)
    slopes = ((surface.at(above) - surface.at(below)) / apart[:, None]).T
    z = (likelihood.log_N - surface.at(place[None])[0, likelihood.kind]) / spread
    # phi^2 / (Phi (1 - Phi)), without a loss of digits far out.
    weight = np.exp(-z * z - log_ndtr(z) - log_ndtr(-z)) / (2 * np.pi * spread * spread)
    each = slopes[likelihood.kind]
    whole = np.einsum("i,ij,ik->jk", weight, each, each) + FLAT * np.eye(place.size)
    values, vectors = np.linalg.eigh(whole)
    vectors *= np.sign(vectors[np.argmax(abs(vectors), axis=0), np.arange(place.size)])
    covariance = (vectors / values) @ vectors.T
    return Information(covariance, slopes, 1 / np.sqrt(values[::-1]), vectors.T[::-1])


def untold(found: Information) -> np.ndarray:
    """Which directions shots tell little of: the ranges say nearly as much; (unknowns,)."""
    return found.widths * np.sqrt(FLAT) > UNTOLD
