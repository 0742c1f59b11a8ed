"""The section `tolerances`: what scatters from device to device, or from shock to shock."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from ...device.samples import DISTRIBUTIONS as SPREADS
from ...device.samples import OF_DEVICE, SAMPLES, SEED, SHOCK_FACTORS, Groups, Samples, Tolerances
from ...files.text import describe
from ...study.axes import KIND_OF
from ...values.kinds import Kind, Quantity, kind_of
from ...values.quantities import Seed, Share
from ...values.records import record, row_of_kinds, told


@dataclass(frozen=True)
class WidthKind(Kind):
    """A width, or a mapping of a kind of distribution to its width; a share stays text."""

    of: Quantity | None

    @property
    def need(self) -> str:
        """What is right, in words that follow "is not"."""
        value = " or a value" if self.of else ""
        return f"a standard deviation, as a share{value}, or a mapping of a kind to its width"

    def read(self, value: object) -> float | str | dict:
        """Read a width, or a mapping."""
        if not isinstance(value, Mapping):
            return self._width(value)
        if len(value) != 1 or next(iter(value)) not in SPREADS:
            raise ValueError(
                f"{describe(value)} is not a mapping of one of {', '.join(SPREADS)} to its width"
            )
        return {spread: self._width(size) for spread, size in value.items()}

    def _width(self, value):
        if isinstance(value, str) and value.strip().endswith("%"):
            return f"{100 * kind_of(Share).read(value):.12g} %"
        if not self.of:
            raise ValueError(f"{describe(value)} is not a share; write one such as '5 %'")
        try:
            return self.of.read(value)
        except ValueError as error:
            raise ValueError(f"{error}, or a share such as '5 %'") from None

    def schema(self) -> dict:
        """Describe a width, or a mapping."""
        width = {"type": ["string", "number"]}
        spreads = {"type": "object", "properties": dict.fromkeys(SPREADS, width)}
        return {"anyOf": [width, spreads | {"additionalProperties": False}]}


def _width(key):
    kind = WidthKind(None if key in SHOCK_FACTORS else KIND_OF[key])
    words = (
        "standard deviation, as a value or a share, or as {uniform: 5 %}; no scatter if left out"
    )
    return Annotated[object, kind], words


@record
class TolerancesSection(
    row_of_kinds("Widths", {key: _width(key) for key in (*OF_DEVICE, *SHOCK_FACTORS)})
):
    """What scatters between devices, or between shocks.

    Kinds are normal, uniform (half the width), lognormal, and truncated at two standard deviations.
    """

    together: Groups = ()
    """groups of names; a single draw moves each"""
    samples: Samples = SAMPLES
    """number of devices"""
    index_samples: Samples | None = None
    """number of devices for Sobol indices, rounded down to a power of two; by default 1024, or
    `samples` if fewer"""
    seed: Seed = SEED
    """seed of the random devices"""

    def __post_init__(self):
        """Raise ValueError for more samples of indices than of all."""
        if (self.index_samples or 0) > self.samples:
            most = f"is more than samples, {self.samples}; write that or less"
            raise ValueError(f"index_samples: {self.index_samples} {most}")

    def tolerances(self) -> Tolerances:
        """Make the request."""
        draws = {name: getattr(self, name) for name in Tolerances._fields[1:]}
        scatters = {key: width for key, width in told(self).items() if key not in draws}
        return Tolerances(scatters, **draws)
