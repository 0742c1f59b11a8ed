"""The table of cells that a solver is given, and what it observes of each."""

from typing import NamedTuple

import numpy as np

from ..device.device import Device
from ..pulse.pulse import Pulse, make_pulse

HANDOUT_PULSES = (make_pulse(),)


class Cells(NamedTuple):
    """Cells in internal units; arrays of one shape.

    device: index of the device in the model's batch; pulse: index in pulses
    amplitude: N g, um/us^2; f0: 1/us; damping: C, uN us/um; t_end: us
    """

    device: np.ndarray
    pulse: np.ndarray
    amplitude: np.ndarray
    f0: np.ndarray
    damping: np.ndarray
    t_end: np.ndarray
    pulses: tuple[Pulse, ...]

    def take(self, which: np.ndarray) -> "Cells":
        """Pick cells by indices or a mask."""
        return Cells._make([*(column[which] for column in self[:-1]), self.pulses])

    def flat(self) -> "Cells":
        """Give the same cells in one dimension."""
        return Cells._make([*map(np.ravel, self[:-1]), self.pulses])


class Rows(NamedTuple):
    """Rows of cells that differ in N alone; arrays (rows,).

    device: index in the model's batch; f0: Hz; C: uN us/um; pulse: index in pulses
    """

    device: np.ndarray
    f0: np.ndarray
    C: np.ndarray
    pulse: np.ndarray
    pulses: tuple[Pulse, ...]

    def take(self, which: np.ndarray | slice) -> "Rows":
        """Pick rows by indices, a mask or a slice."""
        return Rows._make([*(column[which] for column in self[:-1]), self.pulses])

    def cells(self, devices: Device, N, horizon: float) -> Cells:
        """Give their cells, (rows, n), at multiples of g that broadcast so; as `to_cells`."""
        device, f0, C, pulse = (np.expand_dims(column, 1) for column in self[:-1])
        return to_cells(devices, device, N, f0, C, horizon, pulse, self.pulses)


class Observations(NamedTuple):
    """What was observed of each cell; arrays of the shape of the cells.

    t_snap: first arrival of the midpoint at the shape in which it did not start, after the pulse's
        start, us; NaN if not seen
    t_settled: when the beam was seen to be settled in a well for ever, us; NaN if it was not
    well: the side of the saddle at the end of the run, 1 that of the start, 2 the other; 0 if it
        ended at its snap, or in the pulse
    energy_error: residual of the energy ledger over the gross work of the pulse, not finite after
        a blow-up
    well_share: share of the mass's last swing spent on that side; 1 if settled, NaN for well 0
    pulse_work: of all of the pulse on mass and beam, pJ; NaN if the run ended before it or failed
    lowest: of w(L/2), of a run from the second shape of -w(L/2), um, from the first; NaN if the
        model does not tell
    halvings: how often the model's step was halved for these observations
    level: of several that a model has, the one that decided the cell, 0 for the cheapest
    agreed: 0 where two levels disagree on whether the cell snaps, 1 where they agree, 2 where a
        single one followed it

    A run observes all but the last two, which a model of several levels adds.
    """

    t_snap: np.ndarray
    t_settled: np.ndarray
    well: np.ndarray
    energy_error: np.ndarray
    well_share: np.ndarray
    pulse_work: np.ndarray
    lowest: np.ndarray
    halvings: np.ndarray
    level: np.ndarray | None = None
    agreed: np.ndarray | None = None

    def shaped(self, shape: tuple[int, ...]) -> "Observations":
        """Give what runs observed in another shape."""
        return Observations(*(column.reshape(shape) for column in self[:8]))

    def replace(self, which: np.ndarray, others: "Observations") -> None:
        """Set what was observed of some cells, by indices or a mask, in place."""
        for column, part in zip(self[:8], others[:8], strict=True):
            column[which] = part


def no_observations(shape: tuple[int, ...]) -> Observations:
    """Make room for observations of cells: nothing is observed yet, and no ledger closes."""
    return Observations(
        t_snap=np.full(shape, np.nan),
        t_settled=np.full(shape, np.nan),
        well=np.zeros(shape, np.int8),
        energy_error=np.full(shape, np.inf),
        well_share=np.full(shape, np.nan),
        pulse_work=np.full(shape, np.nan),
        lowest=np.full(shape, np.nan),
        halvings=np.zeros(shape, np.int8),
    )


def to_rows(device, f0, C, pulse=0, pulses=HANDOUT_PULSES) -> Rows:
    """Collect rows from arrays that broadcast; f0 in Hz, C in uN us/um; pulse: index in pulses."""
    indices = (np.asarray(column, np.int64) for column in (device, pulse))
    values = (np.asarray(column, float) for column in (f0, C))
    device, pulse, f0, C = (np.ravel(a) for a in np.broadcast_arrays(*indices, *values))
    return Rows(device, f0, C, pulse, pulses)


def to_cells(
    devices: Device, device, N, f0, C, horizon: float, pulse=0, pulses=HANDOUT_PULSES
) -> Cells:
    """Convert cells, arrays that broadcast, from multiples of g, Hz, uN us/um and a horizon.

    devices: one, or a batch; device: indices in it; pulse: indices in pulses
    horizon: time followed after the pulse, us
    """
    indices = (np.asarray(column, np.int64) for column in (device, pulse))
    values = (np.asarray(column, float) for column in (N, f0, C))
    device, pulse, N, f0, C = np.broadcast_arrays(*indices, *values)
    gravity, factor = (np.atleast_1d(a)[device] for a in (devices.gravity, devices.damper_factor))
    f0 = f0 * 1e-6
    # Where there is no mass a damper holds its place at 0, whatever its constant.
    damping = np.where(np.atleast_1d(devices.is_alone)[device], 1.0, C * factor)
    return Cells(device, pulse, N * gravity, f0, damping, 1 / f0 + horizon, pulses)
