"""Values of a device and of its shocks as they scatter: distributions, and samples of them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..checks import show
from ..device import OF_MASS, VALUES

OF_DEVICE = tuple(key for key in VALUES if key != "temperature")
"""Values of the device that scatter: it is as warm as it is."""
SHOCK_FACTORS = ("N", "duration", "C")
"""Values of the shock and of the damper that scatter, too, as shares: they have no nominal ones."""
KINDS = ("normal", "uniform", "lognormal", "truncated")
INDEX_SAMPLES = 1024
"""Of those by which Sobol indices are estimated, by default."""
CUT = 2.0
"""Standard deviations at which a truncated normal distribution ends."""
DIGITS = 7
"""Decimals of a deviation over its width: no library's last digit shows in a sample."""
NEED = "is no number above 0, nor a share such as '5 %'"


class Tolerances(NamedTuple):
    """What is asked of devices as made.

    scatters: of each value the standard deviation, as `snapmap.tolerance` takes it
    together: groups of values that one draw moves
    samples: number of devices
    index_samples: of those by which Sobol indices are estimated, cut down to a power of two, each
        with a partner and one more for each scatter; by default as many as are affordable
    seed: of the draws
    """

    scatters: Mapping[str, float | str | Mapping]
    together: Sequence[Sequence[str]] = ()
    samples: int = 1000
    index_samples: int | None = None
    seed: int = 1


@dataclass(frozen=True)
class Scatter:
    """How one value scatters about its nominal one.

    kind: one of KINDS; width: standard deviation, half width of `uniform`, or that of the normal
        distribution before it is `truncated`
    is_share: whether the width is a share of the nominal value
    """

    kind: str
    width: float
    is_share: bool

    def values(self, nominal: float, u: np.ndarray) -> np.ndarray:
        """Values at cumulative probabilities u, from 0 to 1, any shape."""
        from scipy import stats  # half a second, for which no config that is read has to wait

        if self.kind == "lognormal":
            share = self.width if self.is_share else self.width / nominal
            spread = math.sqrt(math.log1p(share**2))
            # Its mean is the nominal value, and its standard deviation the width.
            return nominal * np.round(np.exp(spread * stats.norm.ppf(u) - spread**2 / 2), DIGITS)
        deviation = {
            "normal": stats.norm.ppf,
            "uniform": lambda u: 2 * u - 1,
            "truncated": lambda u: stats.truncnorm.ppf(u, -CUT, CUT),
        }[self.kind](u)
        width = self.width * abs(nominal) if self.is_share else self.width
        return nominal + width * np.round(deviation, DIGITS)


class Plan:
    """What scatters, by which draws, about which nominal values.

    scatters: by the names of the values; factors: for each draw the values that it moves
    """

    def __init__(self, device, scatters: Mapping, together: Sequence[Sequence[str]] = ()):
        """Take scatters as `scatter_from` does; ValueError, one line, for what cannot be."""
        self.scatters = {key: scatter_from(key, given) for key, given in scatters.items()}
        if not self.scatters:
            raise ValueError("tolerances: name a value that scatters, such as thickness")
        idle = [key for key in self.scatters if key in OF_MASS and device.is_alone]
        if idle:
            raise ValueError(f"tolerances.{idle[0]}: is of the mass, and there is none")
        self.nominal = {key: _nominal(device, key) for key in self.scatters}
        for key, scatter in self.scatters.items():
            if math.isinf(self.nominal[key]):
                what = "a hard contact" if key == "contact" else "what is not there"
                raise ValueError(f"tolerances.{key}: {what} does not scatter")
            if scatter.kind == "lognormal" and not self.nominal[key] > 0:
                raise ValueError(f"tolerances.{key}: lognormal needs a nominal value above 0")
            if scatter.is_share and self.nominal[key] == 0:
                raise ValueError(f"tolerances.{key}: a share of 0 is no scatter; write a width")
        self.factors = _factors(self.scatters, together)

    @property
    def names(self) -> list[str]:
        """A name for each draw: of the values that it moves, joined by +."""
        return ["+".join(keys) for keys in self.factors]

    def points(self, samples: int, seed: int) -> np.ndarray:
        """Cumulative probabilities, (2, samples, draws): two sets that know nothing of each other.

        By a scrambled Sobol sequence; the first of more samples are the same.
        """
        from scipy.stats import qmc

        draws = len(self.factors)
        power = max(1, math.ceil(math.log2(samples)))
        points = qmc.Sobol(2 * draws, seed=seed, bits=32).random_base2(power)[:samples]
        middle = np.clip(points, 0.5**33, 1 - 0.5**33)
        return np.moveaxis(middle.reshape(samples, 2, draws), 1, 0)

    def values(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Values by name, (samples,), at cumulative probabilities, (samples, draws)."""
        return {
            key: self.scatters[key].values(self.nominal[key], u)
            for keys, u in zip(self.factors, points.T, strict=True)
            for key in keys
        }


def scatter_from(key: str, given) -> Scatter:
    """Take what stands for a scatter: a number, a share as text, or a kind with one of these.

    Raises ValueError, one line, naming the key.
    """
    if isinstance(given, Scatter):
        return given
    name = f"tolerances.{key}"
    if key not in (*OF_DEVICE, *SHOCK_FACTORS):
        known = ", ".join((*OF_DEVICE, *SHOCK_FACTORS))
        raise ValueError(f"{name}: is no value that scatters; these are {known}")
    kind, width = "normal", given
    if isinstance(given, Mapping):
        if len(given) != 1 or next(iter(given)) not in KINDS:
            raise ValueError(f"{name}: write one of {', '.join(KINDS)} with its width")
        ((kind, width),) = given.items()
    is_share = isinstance(width, str)
    if isinstance(width, bool) or (is_share and not width.strip().endswith("%")):
        raise ValueError(f"{name}: {show(width)} {NEED}")
    try:
        number = float(width.strip().removesuffix("%")) / 100 if is_share else float(width)
    except (OverflowError, TypeError, ValueError):
        raise ValueError(f"{name}: {show(width)} {NEED}") from None
    if not 0 < number < math.inf:
        raise ValueError(f"{name}: {show(width)} {NEED}")
    if key in SHOCK_FACTORS and not is_share:
        raise ValueError(f"{name}: {show(width)} is no share; write one such as '5 %'")
    return Scatter(kind, number, is_share)


def _nominal(device, key):
    """The nominal value; 1 for those of the shock, which are factors."""
    if key in SHOCK_FACTORS:
        return 1.0
    return float(getattr(device.beam if hasattr(device.beam, key) else device, key))


def _factors(scatters, together):
    """For each draw the values that it moves, in the order of the scatters."""
    group_of = {}
    for group in together:
        for key in group:
            if key not in scatters:
                raise ValueError(f"tolerances.together: {key} does not scatter")
            if key in group_of:
                raise ValueError(f"tolerances.together: {key} comes twice")
            group_of[key] = tuple(one for one in scatters if one in group)
    return tuple(dict.fromkeys(group_of.get(key, (key,)) for key in scatters))
