"""The hard cases with their devices, and the models that follow them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from snapmap.device.device import Device
from snapmap.device.shape import BISTABILITY_LIMIT
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.options import Cosines, Elements, Reference

from ..common import with_beam

APART = 1e-9
"""Relative distance between the amplitudes of a case's cells."""


class Case(NamedTuple):
    """A cell that is hard for the scheme, with near copies of itself.

    N: multiples of g, or of the model's threshold if `of_threshold`
    f0: Hz; C: uN us/um; horizon: time followed after the pulse, us
    contact (uN/um), Q (rise over thickness), beam_damping (1/us): None for those of the device
    cells: number of cells; each N is APART below the one before, relative
    """

    name: str
    N: float
    f0: float = 1500.0
    C: float = 0.025
    horizon: float = 1500.0
    of_threshold: bool = False
    contact: float | None = None
    Q: float | None = None
    beam_damping: float | None = None
    cells: int = LANES


HARD = np.inf
CASES = (
    Case("handout's case", 1000.0),
    Case("five times as strong", 5000.0),
    Case("contact 4e5 N/m", 1000.0, horizon=300.0, contact=4e5),
    Case("hard contact", 1000.0, horizon=300.0, contact=HARD),
    Case("hard contact, C = 0, 20 ms", 1500.0, C=0.0, horizon=2e4, contact=HARD),
    Case("C = 0, 1 s", 1500.0, C=0.0, horizon=1e6),
    Case("1 % below the threshold", 0.99, of_threshold=True),
    Case("at the threshold", 1.0, of_threshold=True),
    Case("1 % above the threshold", 1.01, of_threshold=True),
    Case("f0 = 10 Hz", 1000.0, f0=10.0, horizon=300.0),
    Case("f0 = 100 kHz", 12000.0, f0=1e5, horizon=300.0),
    Case("N = 0", 0.0, f0=1e4, horizon=100.0),
    Case("N = 1e-6", 1e-6, f0=1e4, horizon=100.0),
    Case("N = -1000", -1000.0, f0=5e3, horizon=100.0),
    Case("N = 1e6", 1e6, f0=1e4, horizon=0.0),
    Case("Q 0.01 % above its limit", 300.0, f0=1e4, horizon=50.0, Q=1.0001 * BISTABILITY_LIMIT),
    Case("chaotic", 1500.0, C=25.0, horizon=6000.0, cells=64),
    Case("chaotic, damped beam", 1500.0, C=25.0, horizon=6000.0, beam_damping=4e-4, cells=64),
)
MODELS = {
    **{f"{n} cosines": Cosines(modes=n) for n in (1, 2, 3, 5, 8, 12)},
    "1 element": Elements(elements=1),
    "5 elements": Elements(elements=5),
    "20 elements": Elements(elements=20),
    "20 elements, 4 modes": Elements(elements=20, modes=4),
    "reference": Reference(),
}
"""Each model, by its label in the figure."""


def changed(device: Device, case: Case) -> Device:
    """Return the device with the changes of a case."""
    if case.Q is not None:
        device = with_beam(device, rise=case.Q * device.beam.thickness)
    if case.beam_damping is not None:
        device = with_beam(device, damping=case.beam_damping)
    return replace(device, contact=case.contact or device.contact)
