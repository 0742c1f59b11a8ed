"""Values of a device and of its shocks as they scatter: distributions, and samples of them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.stats import qmc

from ..device import VALUES

SHOCK = ("N", "duration")
"""Values of the shock that scatter, too; a test machine does not repeat itself."""
KINDS = ("normal", "uniform", "lognormal", "truncated")
CUT = 2.0
"""Standard deviations at which a truncated normal distribution ends."""
DIGITS = 12
"""To which samples are rounded, so that no library's last digit shows."""


@dataclass(frozen=True)
class Scatter:
    """How one value scatters about its nominal one.

    kind: one of KINDS; width: standard deviation, or half width of `uniform`
    is_share: whether the width is a share of the nominal value
    """

    kind: str
    width: float
    is_share: bool

    def factor(self, nominal: float, u: np.ndarray) -> np.ndarray:
        """Values over the nominal one at cumulative probabilities u from 0 to 1, any shape."""
        width = self.width if self.is_share else self.width / nominal
        if self.kind == "uniform":
            return 1 + width * (2 * u - 1)
        if self.kind == "lognormal":
            return np.exp(math.sqrt(math.log1p(width**2)) * stats.norm.ppf(u))
        if self.kind == "truncated":
            return 1 + width * stats.truncnorm.ppf(u, -CUT, CUT)
        return 1 + width * stats.norm.ppf(u)


def scatter_from(key: str, given) -> Scatter:
    """Take what stands for a scatter: a number, a share as text, or a kind with one of these.

    Raises ValueError, one line, naming the key.
    """
    if key not in (*VALUES, *SHOCK):
        raise ValueError(f"{key}: no value that scatters; these are {', '.join((*VALUES, *SHOCK))}")
    kind, width = "normal", given
    if isinstance(given, Mapping):
        if len(given) != 1 or next(iter(given)) not in KINDS:
            raise ValueError(f"{key}: write one of {', '.join(KINDS)} with its width")
        ((kind, width),) = given.items()
    is_share = isinstance(width, str)
    text = width.strip().removesuffix("%") if is_share else width
    try:
        number = float(text) / (100 if is_share else 1)
    except (TypeError, ValueError):
        raise ValueError(f"{key}: {width!r} is no number, nor a share such as '5 %'") from None
    if isinstance(width, bool) or (is_share and not width.strip().endswith("%")):
        raise ValueError(f"{key}: {width!r} is no number, nor a share such as '5 %'")
    if not 0 <= number < math.inf:
        raise ValueError(f"{key}: {width!r} is not 0 or above")
    return Scatter(kind, number, is_share)


def draw(
    nominal: Mapping[str, float],
    scatters: Mapping[str, Scatter],
    together: Sequence[Sequence[str]],
    samples: int,
    seed: int,
) -> dict[str, np.ndarray]:
    """Draw values by a scrambled Sobol sequence, (samples,) each, the same for the same seed.

    together: groups of values that one draw moves, each by its own scatter
    """
    column = {key: place for place, key in enumerate(scatters)}
    for group in together:
        column |= {key: column[group[0]] for key in group[1:]}
    used = sorted(set(column.values()))
    power = max(1, math.ceil(math.log2(samples)))
    points = qmc.Sobol(len(used), seed=seed).random_base2(power)[:samples]
    values = {}
    for key, scatter in scatters.items():
        u = np.clip(points[:, used.index(column[key])], 0.5**32, 1 - 0.5**32)
        values[key] = rounded(nominal[key] * scatter.factor(nominal[key], u))
    return values


def rounded(values: np.ndarray) -> np.ndarray:
    """To DIGITS digits."""
    return np.array([float(f"{value:.{DIGITS}g}") for value in values.tolist()])
