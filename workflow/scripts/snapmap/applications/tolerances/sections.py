"""The section `tolerances`: what scatters from device to device, or from shock to shock."""

from ...device.samples import SAMPLES, SEED, Groups, Samples, Tolerances, Widths
from ...values.quantities import Seed
from ...values.records import record, told


@record
class TolerancesSection(Widths):
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
