"""Thresholds of the handout's device, beside the 1000 g for which it was designed.

./run python -m studies measured
"""

from dataclasses import replace

import numpy as np

from snapmap import Study, threshold

from .common import command_device, few
from .tables import Table, write

PULSES = {"versed sine": [500.0, 1500.0, 5000.0], "half sine": [1500.0]}
"""Frequencies f0, Hz, of each pulse; the handout's is a versed sine of 1500 Hz."""
CONTACTS = {"contact 40 N/m": 40.0, "hard contact": np.inf}
C = [0.025, 25.0]
"""The handout's damper, which is next to none, and one of a quality factor of 9, uN us/um."""


def main():
    device = command_device()
    devices = [replace(device, contact=contact) for contact in CONTACTS.values()]
    columns = [column for each in devices for column in np.transpose([*thresholds(each)])]
    pulses = [f"{shape}, {f0:g} Hz" for shape in few(PULSES) for f0 in PULSES[shape]]
    head = ["pulse", *(f"{contact}, C = {c:g}" for contact in CONTACTS for c in C)]
    rows = zip([*pulses, "slow"], *columns, strict=True)
    write("measured", Table("measured", head, [*map(list, rows)]))


def thresholds(device):
    """Yield thresholds with their bars, as text by C, for each pulse and for a slow one."""
    for shape in few(PULSES):
        found = threshold(Study(device, pulse=shape), f0=PULSES[shape], C=C)
        for f0 in PULSES[shape]:
            values = (found[key].sel(f0=f0).values for key in ("N_first", "N_error"))
            yield [f"{N:.1f} ± {error:.1f}" for N, error in zip(*values, strict=True)]
    yield [f"{found.N_static.item():.1f}"] * len(C)
