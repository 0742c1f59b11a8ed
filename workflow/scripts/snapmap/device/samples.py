"""Scatter of a device and its shocks: distributions of their values, and samples."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from ..files.text import describe, show
from ..values.arguments import Reading
from ..values.kinds import Fitting, Kind, Quantity, Whole, kind_of
from ..values.quantities import Share, single
from ..values.records import ByKeys, row_of_kinds
from .device import KINDS, OF_MASS, VALUES, Device

OF_DEVICE = tuple(key for key in VALUES if key != "temperature")
"""Names of the device's values that may scatter; its temperature does not."""
SHOCK_FACTORS = ("N", "duration", "C")
"""Values of shock and damper that may scatter, as factors of their values in a study."""
DISTRIBUTIONS = ("normal", "uniform", "lognormal", "truncated")
SAMPLES, INDEX_SAMPLES, SEED = 1000, 1024, 1
"""Defaults: samples, samples that estimate Sobol indices, and seed."""
FOLLOWED_CELLS, FEWEST_FOLLOWED = 1_000_000, 64
"""Most cells that are followed to their end; at least the cells of so many samples are."""
CUT = 2.0
"""Standard deviations at which a truncated normal distribution ends."""
_FACTOR = single("a factor")
DIGITS = 7
"""Decimals to which deviations over their width are rounded, so libraries cannot differ."""


def _are_groups(value):
    groups = value if isinstance(value, list | tuple) else [value]
    are_lists = all(isinstance(group, list | tuple) for group in groups)
    return are_lists and all(isinstance(key, str) for group in groups for key in group)


class Scatter(NamedTuple):
    """The distribution of a value about its nominal value.

    distribution: one of DISTRIBUTIONS
    width: standard deviation, of `truncated` before it is cut; half width of `uniform`
    is_share: whether the width is a share of the nominal value
    """

    distribution: str
    width: float
    is_share: bool

    def values(self, nominal: float, u: np.ndarray) -> np.ndarray:
        """Return the values at cumulative probabilities u, from 0 to 1, in the shape of u."""
        from scipy import stats  # imported late: it takes half a second

        if self.distribution == "lognormal":
            share = self.width if self.is_share else self.width / nominal
            spread = math.sqrt(math.log1p(share**2))
            # The mean is the nominal value, and the standard deviation is the width.
            return nominal * np.round(np.exp(spread * stats.norm.ppf(u) - spread**2 / 2), DIGITS)
        deviation = {
            "normal": stats.norm.ppf,
            "uniform": lambda u: 2 * u - 1,
            "truncated": lambda u: stats.truncnorm.ppf(u, -CUT, CUT),
        }[self.distribution](u)
        width = self.width * abs(nominal) if self.is_share else self.width
        return nominal + width * np.round(deviation, DIGITS)

    @property
    def written(self) -> float | str | dict[str, float | str]:
        """The scatter as a config has it, in internal units."""
        width = f"{100 * self.width:.12g} %" if self.is_share else self.width
        return width if self.distribution == "normal" else {self.distribution: width}


@dataclass(frozen=True)
class Width(Kind):
    """How a value scatters: a standard deviation, or a mapping of a distribution to its width.

    of: the value; None where only shares are right
    """

    of: Quantity | None
    type = float | str | dict[str, float | str]

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        value = " or a value" if self.of else ""
        return f"a standard deviation, as a share{value}, or a mapping of a kind to its width"

    def convert(self, value: object, reading: Reading) -> Scatter:
        """Convert a width, or a mapping."""
        distribution = "normal"
        if isinstance(value, Mapping):
            if len(value) != 1 or next(iter(value)) not in DISTRIBUTIONS:
                need = f"a mapping of one of {', '.join(DISTRIBUTIONS)} to its width"
                raise ValueError(f"{describe(value)} is not {need}")
            ((distribution, value),) = value.items()
        if isinstance(value, str) and value.strip().endswith("%"):
            kind_of(Share).read(value)
            return Scatter(distribution, float(value.strip()[:-1]) / 100, True)
        if not self.of:
            raise ValueError(f"{describe(value)} is not a share; write one such as '5 %'")
        try:
            width = self.of.convert(value, reading)
        except ValueError as error:
            raise ValueError(f"{error}, or a share such as '5 %'") from None
        if np.ndim(width) or not 0 < width < math.inf:
            raise ValueError(f"{show(value)} is not above 0; write a width, or a share as '5 %'")
        return Scatter(distribution, width, False)

    def schema(self) -> dict:
        """Describe a width, or a mapping."""
        width = {"type": ["string", "number"]}
        spreads = {"type": "object", "properties": dict.fromkeys(DISTRIBUTIONS, width)}
        return {"anyOf": [width, spreads | {"additionalProperties": False}]}


def _width(key):
    words = (
        "standard deviation, as a value or a share, or as {uniform: 5 %}; no scatter if left out"
    )
    return Annotated[object, Width(KINDS.get(key))], words


Widths = row_of_kinds("Widths", {key: _width(key) for key in (*OF_DEVICE, *SHOCK_FACTORS)})
Samples = Annotated[int, Whole(2, 100_000)]
_JSON = {"type": "array", "items": {"type": "array", "items": {"type": "string"}}}
_GROUPS = Fitting("a list of groups of names, as [[span, rise]]", _are_groups, json=_JSON)
Groups = Annotated[Sequence[Sequence[str]], _GROUPS]
_SCATTERS = 'a mapping of what can scatter to its width, such as {"thickness": "3 %"}'
_WIDTHS = ByKeys(Widths, _SCATTERS, "cannot scatter", least=1)
Scatters = Annotated[Mapping[str, float | str | Mapping], _WIDTHS]


class Tolerances(NamedTuple):
    """A request for devices as made.

    scatters: how each value scatters
    together: groups of values that share a draw
    samples: number of devices
    index_samples: samples that estimate Sobol indices, rounded down to a power of two; each takes
        2 devices and one more for each scatter; None for up to INDEX_SAMPLES
    seed: of the draws
    """

    scatters: Mapping[str, Scatter]
    together: Sequence[Sequence[str]] = ()
    samples: int = SAMPLES
    index_samples: int | None = None
    seed: int = SEED

    @property
    def section(self) -> dict:
        """The request in plain values, as provenance records it."""
        draws = {"samples": self.samples, "seed": self.seed, "together": self.together}
        return {key: scatter.written for key, scatter in self.scatters.items()} | draws

    @property
    def power(self) -> int:
        """Number of samples that estimate Sobol indices, a power of two."""
        return 1 << (min(self.samples, self.index_samples or INDEX_SAMPLES).bit_length() - 1)

    def followed(self, cells: int) -> int:
        """Return how many samples, of so many cells each, are followed to the end."""
        return min(self.samples, max(FEWEST_FOLLOWED, FOLLOWED_CELLS // cells))


class Plan:
    """A plan of samples.

    scatters, nominal: of each value, by name; factors: for each draw, the values that it moves
    """

    def __init__(
        self, device, scatters: Mapping[str, Scatter], together: Sequence[Sequence[str]] = ()
    ):
        """Take scatters; raises ValueError, one line, for those that a device cannot have."""
        self.scatters = dict(scatters)
        if not self.scatters:
            raise ValueError("tolerances: empty; write a value that scatters, such as thickness")
        self.nominal = {}
        for key, scatter in self.scatters.items():
            if key in OF_MASS and device.is_alone:
                raise ValueError(f"tolerances.{key}: needs a mass; leave it out")
            nominal = self.nominal[key] = nominal_value(device, key)
            if math.isinf(nominal):
                what = "hard" if key == "contact" else "none in this device"
                raise ValueError(f"tolerances.{key}: {what}, so it cannot scatter; leave it out")
            if scatter.distribution == "lognormal" and not nominal > 0:
                raise ValueError(f"tolerances.{key}: lognormal needs a nominal value above 0")
            if scatter.is_share and nominal == 0:
                raise ValueError(f"tolerances.{key}: a share of 0 is 0; write a width with a unit")
        group_of = {}
        for group in together:
            for key in group:
                if key not in scatters:
                    raise ValueError(f"tolerances.together: {key} has no tolerance")
                if key in group_of:
                    raise ValueError(f"tolerances.together: {key} comes twice")
                group_of[key] = tuple(name for name in scatters if name in group)
        self.factors = tuple(dict.fromkeys(group_of.get(key, (key,)) for key in scatters))

    @property
    def names(self) -> list[str]:
        """Name of each draw: the values that it moves, joined by +."""
        return ["+".join(keys) for keys in self.factors]

    def points(self, samples: int, seed: int) -> np.ndarray:
        """Draw two independent sets of cumulative probabilities, (2, samples, draws).

        They follow a scrambled Sobol sequence; with more samples the first ones stay the same.
        """
        from scipy.stats import qmc

        draws = len(self.factors)
        power = math.ceil(math.log2(samples))
        points = qmc.Sobol(2 * draws, seed=seed, bits=32).random_base2(power)[:samples]
        above = np.maximum(points, 0.5**33)  # they are multiples of 0.5**32, from 0
        return np.moveaxis(above.reshape(samples, 2, draws), 1, 0)

    def values(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return values by name, (samples,), at cumulative probabilities, (samples, draws).

        Raises ValueError, one line, for an impossible value.
        """
        values = {
            key: self.scatters[key].values(self.nominal[key], u)
            for keys, u in zip(self.factors, points.T, strict=True)
            for key in keys
        }
        for key, column in values.items():
            wrong = column[~KINDS.get(key, _FACTOR).bounds.holds(column)]
            if wrong.size:
                raise ValueError(
                    f"tolerances.{key}: a sample has the impossible value {wrong[0]:.4g}; write "
                    f"truncated or lognormal, or a smaller scatter about {self.nominal[key]:g}"
                )
        return values


def nominal_value(device: Device, key: str) -> float:
    """Return the nominal value; 1 for SHOCK_FACTORS."""
    if key in SHOCK_FACTORS:
        return 1.0
    return float(getattr(device.beam if hasattr(device.beam, key) else device, key))
