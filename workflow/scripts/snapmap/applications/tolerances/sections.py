"""The section `tolerances`: what scatters from device to device, or from shock to shock."""

from collections.abc import Mapping

from ...config.devices import of_device
from ...config.keys import argument, key
from ...config.units import read, show
from ...device.samples import DISTRIBUTIONS as SPREADS
from ...device.samples import (
    INDEX_SAMPLES,
    OF_DEVICE,
    SHOCK_FACTORS,
    Groups,
    Samples,
    Tolerances,
)
from ...study import arguments

_DRAWN = Tolerances._field_defaults


def _scatter(name, kind, example=""):
    """Make the type of a width, or a mapping of a kind to its width; a share stays text."""

    def width(value):
        if isinstance(value, str) and value.strip().endswith("%"):
            return f"{100 * read(value, 'share'):.12g} %"
        if name in SHOCK_FACTORS:
            raise ValueError(f"{show(value)} is not a share; write one such as '5 %'")
        try:
            return read(value, kind)
        except ValueError as error:
            raise ValueError(f"{error}, or a share such as '5 %'") from None

    def convert(value):
        if not isinstance(value, Mapping):
            return width(value)
        if len(value) != 1 or next(iter(value)) not in SPREADS:
            raise ValueError(
                f"{show(value)} is not a mapping of one of {', '.join(SPREADS)} to its width"
            )
        return {spread: width(size) for spread, size in value.items()}

    value = "" if name in SHOCK_FACTORS else " or a value"
    need = f"a standard deviation, as a share{value}, or a mapping of a kind to its width"
    return key(convert, need, example=example, out="no scatter")


class TolerancesSection(of_device(_scatter, OF_DEVICE)):
    """What scatters between devices, or between shocks.

    Kinds are normal, uniform (half the width), lognormal, and truncated at two standard deviations.
    """

    C: _scatter("C", "", "10 %")
    N: _scatter("N", "", "2 %")
    duration: _scatter("duration", "", "{uniform: 5 %}")
    together: argument(
        Groups,
        "a single draw moves each group",
        example="[[thickness, depth]]",
        out="each value by itself",
    )
    samples: argument(Samples, "number of devices", out=f"`{_DRAWN['samples']}`")
    index_samples: argument(
        Samples,
        "number of devices for Sobol indices, rounded down to a power of two",
        out=f"`{INDEX_SAMPLES}`, or `samples` if fewer",
    )
    seed: argument(arguments.Seed, "seed of the random devices", out=f"`{_DRAWN['seed']}`")

    def make(self) -> Tolerances:
        """Make the Tolerances; ValueError, one line, for more samples of indices than of all."""
        options = {name: self.given[name] for name in Tolerances._fields if self.has(name)}
        scatters = {name: width for name, width in self.given.items() if name not in options}
        tolerances = Tolerances(scatters, **options)
        if (tolerances.index_samples or 0) > tolerances.samples:
            most = f"is more than samples, {tolerances.samples}; write that or less"
            raise ValueError(f".index_samples: {tolerances.index_samples} {most}")
        return tolerances
