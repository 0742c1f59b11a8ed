"""What a run of the plain loop takes, and its ledger, history and results."""

from typing import NamedTuple

import numpy as np

from ..numerics import pieces as curve
from ..numerics.kernels import compiled


class CellRun(NamedTuple):
    """A run of a cell in the plain loop; units um, ng, us.

    pulse: pieces and ends, as `Pulse.curve` has them, over x = f0 t
    amplitude: N g, um/us^2; f0: 1/us; damping: C, uN us/um; target: w(L/2) from rest, um
    steps: number of steps of dt
    history: (samples, 2 n + 4), modified in place: u, du/dt, y, dy/dt, work of the pulse and
        energy lost (pJ), at as many of the first instants as it holds
    """

    pulse: tuple
    amplitude: float
    f0: float
    damping: float
    target: float
    dt: float
    steps: int
    history: np.ndarray


class Ledger(NamedTuple):
    """What a run has gained and lost since its begin, pJ, and the powers at its last instant.

    begun: energy at the begin
    power, work, gross_work: of the pulse, net and in magnitudes; loss, lost: by dampers and stops
    """

    begun: float
    power: float
    work: float
    gross_work: float
    loss: float
    lost: float


@compiled
def opened(begun: float) -> Ledger:
    """Return the ledger of a run that begins with this energy."""
    return Ledger(begun, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def entered(ledger: Ledger, power: float, loss: float, dt: float) -> Ledger:
    """Return the ledger a step later, by the trapezoidal rule; power, loss: at its instant."""
    return Ledger(
        ledger.begun,
        power,
        ledger.work + (ledger.power + power) * dt / 2,
        ledger.gross_work + abs(power) * dt,
        loss,
        ledger.lost + (ledger.loss + loss) * dt / 2,
    )


@compiled
def bounced(ledger: Ledger, pushed: float, taken: float) -> Ledger:
    """Return the ledger after a bounce; pushed: work of the pulse in it; taken: by the stop."""
    begun, power, work, gross_work, loss, lost = ledger
    return Ledger(begun, power, work + pushed, gross_work + abs(pushed), loss, lost + taken)


@compiled
def keep(row: np.ndarray, u: np.ndarray, velocity: np.ndarray, numbers: tuple[float, ...]) -> None:
    """Write an instant into its row of a history; numbers: the last four."""
    n = u.size
    row[:n], row[n : 2 * n] = u, velocity
    row[2 * n :] = numbers


@compiled
def results(
    run: CellRun, step: int, sides: tuple[float, float], ledger: Ledger, residual: float
) -> tuple[float, float, float]:
    """Return t_snap, energy_error and pulse_work of a run that ends after a step.

    sides: side w(L/2) now and after the step; residual: of the ledger, pJ
    """
    w, w_after = sides
    t_snap, pulse_work = np.nan, np.nan
    if w_after <= run.target:
        t_snap = (step + (w - run.target) / (w - w_after)) * run.dt
    if step + 1 >= curve.lasts(run.pulse[1][1], run.f0 * run.dt):
        pulse_work = ledger.work + ledger.power * run.dt / 2
    error = abs(residual)
    return t_snap, error / ledger.gross_work if ledger.gross_work > 0 else error, pulse_work
