"""Cells, the runs of a solver, and what it observes in each."""

from typing import NamedTuple

import numpy as np

from ..device.device import Device
from ..pulse.pulse import Pulse, make_pulse

HANDOUT_PULSES = (make_pulse(),)


class Cells(NamedTuple):
    """Cells in internal units; all columns but pulses are arrays of one shape.

    device: index in the model's batch; pulse: index in pulses
    amplitude: N g, um/us^2; f0: 1/us; damping: C at the device's temperature, uN us/um
    t_end: end of the run, us
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
        """Return the same cells in one dimension."""
        return Cells._make([*map(np.ravel, self[:-1]), self.pulses])


class Rows(NamedTuple):
    """Rows of cells that differ in N alone; all columns but pulses are (rows,).

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
        """Make cells, (rows, n), at N, multiples of g, that broadcast to this; see `to_cells`."""
        device, f0, C, pulse = (np.expand_dims(column, 1) for column in self[:-1])
        return to_cells(devices, device, N, f0, C, horizon, pulse, self.pulses)


class Observations(NamedTuple):
    """Observations of cells; arrays of the shape of the cells. Times count from the pulse's start.

    t_snap: first arrival of the midpoint at the other shape, us; NaN if it does not arrive
    t_settled: time from which this run stays in a well for ever, by its energy, us; NaN if unknown
    well: side of the saddle at the end of the run, 1 of the start, 2 the other; 0 if the run ended
        at its snap, or in the pulse
    energy_error: residual of the energy ledger over the gross work of the pulse; not finite after
        a blow-up
    well_share: share of the mass's last swing spent on that side; 1 if settled, NaN for well 0
    pulse_work: work of the whole pulse on mass and beam, pJ; NaN if the run ended in it or failed
    lowest: lowest w(L/2) from the first shape, um, or -w(L/2) in a run from the second shape; NaN
        if the model does not record it
    halvings: number of halvings of the model's step
    level: level that decided the cell, in a model of several; 0 is the cheapest
    agreed: 1 where two levels agree on whether the cell snaps, 0 where they disagree, 2 where a
        single level followed it

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

    def take(self, which: tuple | np.ndarray) -> "Observations":
        """Take the observations of a run of some cells, by indices or a mask."""
        return Observations(*(column[which] for column in self[:8]))

    def shaped(self, shape: tuple[int, ...]) -> "Observations":
        """Return the observations of runs in another shape."""
        return Observations(*(column.reshape(shape) for column in self[:8]))

    def replace(self, which: np.ndarray, others: "Observations") -> None:
        """Replace the observations of some cells, by indices or a mask, in place."""
        for column, part in zip(self[:8], others[:8], strict=True):
            column[which] = part


def no_observations(shape: tuple[int, ...]) -> Observations:
    """Make observations of cells not yet followed: nothing is seen, and no ledger closes."""
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


def _alike(device, pulse, *values):
    """Broadcast indices of devices and pulses, and numbers, to arrays of one shape."""
    numbers = (np.asarray(column, float) for column in values)
    return np.broadcast_arrays(np.asarray(device, np.int64), np.asarray(pulse, np.int64), *numbers)


def to_rows(device, f0, C, pulse=0, pulses=HANDOUT_PULSES) -> Rows:
    """Make rows of arrays that broadcast; f0: Hz; C: uN us/um; pulse: index in pulses."""
    device, pulse, f0, C = map(np.ravel, _alike(device, pulse, f0, C))
    return Rows(device, f0, C, pulse, pulses)


def to_cells(
    devices: Device, device, N, f0, C, horizon: float, pulse=0, pulses=HANDOUT_PULSES
) -> Cells:
    """Make cells of arrays that broadcast: N in multiples of g, f0 in Hz, C in uN us/um.

    devices: a single one, or a batch; device: indices in it; pulse: indices in pulses
    horizon: time followed after the pulse, us
    """
    device, pulse, N, f0, C = _alike(device, pulse, N, f0, C)
    gravity, factor = (np.atleast_1d(a)[device] for a in (devices.gravity, devices.damper_factor))
    f0 = f0 * 1e-6
    # Without a mass a damper of any constant keeps y at 0.
    damping = np.where(np.atleast_1d(devices.is_alone)[device], 1.0, C * factor)
    return Cells(device, pulse, N * gravity, f0, damping, 1 / f0 + horizon, pulses)
