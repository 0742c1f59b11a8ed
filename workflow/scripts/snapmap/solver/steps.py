"""How long the time steps of a run are: by the question, the pulse and the device; and limits."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..beam.modal import ModalBeam, column, contact_stiffness
from ..device.device import Device, Value
from ..numerics.linalg import dot, eigenvalues, outer, solve
from .cells import Cells
from .settings import EDGE, MOVE, QUESTIONS, SNAP, STAY

# ASSUME: chosen by measurement, see docs/accuracy.md.
OF_LIMIT = 0.8
"""Step of central differences over their limit of stability."""
# ASSUME: no run bends the beam further than this multiple of its start; see docs/accuracy.md.
TENSION_REACH = 1.25
FEWEST_STEPS = 16
"""Steps in each swing of any pulse: its sum is then exact to 1e-4."""
MORE = 1.5
"""No factor makes the steps of the shortest pulses and fastest blows longer than so many times."""
# ASSUME: the steps are chosen by measurement, see docs/accuracy.md.
PER_SWING = 500
"""Steps in each swing of a pulse that is slow for the device."""
SHORTEST = 0.15
"""Shortest step, in units of 1/omega of the arch; only FEWEST_STEPS asks for shorter ones."""
BLOWS = 400.0
"""Radians of the arch in each swing of a pulse up to which EDGE has the shortest steps: below,
blows decide. Longer pulses leave it steps that grow with the square of their length."""
LONGEST = {SNAP: 0.25, EDGE: 0.25, STAY: 0.5, MOVE: 0.12}
"""Longest step, in units of 1/omega of the arch, by question."""
LONGEST_PRESSED = 2.5
"""The same for SNAP and EDGE of a mass that is pressed on the beam and strikes without a run-up,
unless its spring holds it back."""
MOST, MOST_ALONE = 1100.0, 20_000.0
"""Steps in each swing of a smooth pulse that are enough for SNAP and EDGE, however slow: the beam
follows it from rest to rest. The second where it snaps alone, without a mass, or as its spring
holds the mass back."""
HEAVY, HOLDS = 16.0, 5.0
"""Mass over the beam's with whose fourth root they grow, and stiffness of a spring over the clamped
beam's, 192 EI/L^3, from which on it holds the mass back, so that the beam leaves it."""
STRIKE_TURN = 2.0
"""Radians a step that the fastest mode turns by the tension in which a mass that flies stretches
the beam; in longer steps energy is kept and goes to the wrong modes."""


@dataclass(frozen=True, eq=False)
class Steps:
    """The rule of the steps of a batch of devices.

    longest: us, (devices,), by question
    shortest: us, (devices,): so long a step resolves the device, however short the pulse
    blows: us, (devices,): swings up to which blows decide
    pressed: us, (devices,): longest for SNAP and EDGE where it is pressed on the beam
    returns: whether it comes back from a stop, (devices,)
    most: steps in each swing of a smooth pulse that are enough for SNAP and EDGE, (devices,)
    tightening: 1/(um us), (devices,): square of the frequency of the fastest mode by the tension of
        a strike, over the speed of the mass
    per_swing: steps in each swing of a pulse
    factor: by which all are multiplied
    """

    longest: Mapping[str, np.ndarray]
    shortest: np.ndarray
    blows: np.ndarray
    pressed: np.ndarray
    returns: np.ndarray
    most: np.ndarray
    tightening: np.ndarray
    per_swing: float
    factor: float = 1.0

    def of(self, cells: Cells, question: str, speed: np.ndarray | float = 0.0) -> np.ndarray:
        """Time step of each cell, us, in the cells' shape.

        speed: of a mass that starts apart from the beam, whatever the gap, um/us; 0 of others
        """
        swings = np.array([pulse.swings for pulse in cells.pulses])[cells.pulse]
        swing = 1 / (swings * cells.f0)
        resolved, shortest = swing / self.per_swing, self.shortest[cells.device]
        if question == EDGE:
            strikes = (swing / self.blows[cells.device]) ** 2
            resolved = np.minimum(resolved, strikes * shortest)
        longest = self.longest[question][cells.device]
        if question in (SNAP, EDGE):
            smooth, strikes = np.array([(p.is_smooth, p.strikes) for p in cells.pulses]).T
            rests = ~(strikes[cells.pulse] | self.returns[cells.device] | (speed > 0))
            slow = np.where(smooth[cells.pulse], swing / self.most[cells.device], 0.0)
            longest = np.where(rests, np.maximum(self.pressed[cells.device], slow), longest)
        step = np.minimum(longest, np.maximum(resolved, shortest))
        factor = min(self.factor, MORE)
        step = np.minimum(self.factor * step, factor * swing / FEWEST_STEPS)
        turn = step * np.sqrt(self.tightening[cells.device] * speed)
        return step / np.maximum(turn / (factor * STRIKE_TURN), 1.0)

    def times(self, factor: float) -> "Steps":
        """Give the same rule with every step multiplied by `factor`, but for very short pulses."""
        return replace(self, factor=factor * self.factor)

    def pick(self, which: int | np.ndarray) -> "Steps":
        """Give the rule of one device of the batch, or of several."""
        which = np.atleast_1d(which)
        longest = {question: step[which] for question, step in self.longest.items()}
        columns = {key: a[which] for key, a in vars(self).items() if isinstance(a, np.ndarray)}
        return replace(self, longest=longest, **columns)


def fixed(dt: np.ndarray) -> Steps:
    """Give the rule of one step for each device, us, (devices,), but for very short pulses."""
    return Steps(
        longest=dict.fromkeys(QUESTIONS, dt),
        shortest=dt,
        blows=dt,
        pressed=dt,
        returns=np.zeros(dt.shape, bool),
        most=np.full(dt.shape, np.inf),
        tightening=np.zeros(dt.shape),
        per_swing=FEWEST_STEPS,
    )


def spring_share(device: Device) -> Value:
    """How far the spring holds the mass back, so that the beam snaps alone, from 0 to 1."""
    over = device.spring / (HOLDS * 192 * device.beam.stiffness_unit)
    cube = over * over * over
    return np.where(device.is_alone, 1.0, cube * cube / (1 + cube * cube))


def most_steps(device: Device) -> Value:
    """Steps in each swing of a smooth pulse that are enough, however slow."""
    beam, share = device.beam, spring_share(device)
    heavy = 1 + device.mass / (HEAVY * beam.mass_per_length * beam.span)
    return (1 - share) * MOST * np.sqrt(np.sqrt(heavy)) + share * MOST_ALONE


def strike_tightening(device: Device, modal: ModalBeam) -> Value:
    """Square of the frequency of the fastest mode over the speed of a mass that strikes, 1/(um us).

    By tension alone, that of a beam whose stretch has taken the energy of the mass: T = axial Q,
    axial Q^2/4 = M v^2/2. The kernel turns a mode by itself as it should, not by tension.
    """
    return np.sqrt(2 * device.mass * modal.axial) * modal.geometric[..., -1, -1]


def largest_speed(device: Device, cells: Cells) -> np.ndarray:
    """Most that a pulse can move a mass on its spring without damping, um/us, in the cells' shape.

    No more than by all of its area, nor by all of its ups and downs; 0 where there is no mass.
    """
    facts = np.array([(pulse.gross_area, pulse.variation) for pulse in cells.pulses])
    gross, ups_and_downs = facts.T[:, cells.pulse]
    swing = ups_and_downs / np.atleast_1d(device.mass_frequency)[cells.device]
    speed = abs(cells.amplitude) * np.minimum(gross / cells.f0, swing)
    return np.where(np.atleast_1d(device.is_alone)[cells.device], 0.0, speed)


def explicit_steps(device: Device, modal: ModalBeam) -> Steps:
    """Give the rule of central differences, one step for each device."""
    return fixed(np.atleast_1d(OF_LIMIT * stability_limit(device, modal)))


def steps_of(device: Device, modal: ModalBeam) -> Steps:
    """Give the rule of a device or a batch."""
    period = np.atleast_1d(1 / arch_frequency(modal))
    crosses = np.greater(device.gap, 0) & np.isfinite(device.gap)
    share = np.where(crosses, 1.0, spring_share(device))
    pressed = LONGEST_PRESSED + (LONGEST[SNAP] - LONGEST_PRESSED) * share
    return Steps(
        longest={question: turn * period for question, turn in LONGEST.items()},
        shortest=SHORTEST * period,
        blows=BLOWS * period,
        pressed=pressed * period,
        returns=np.broadcast_to(device.has_stops, period.shape),
        most=np.broadcast_to(most_steps(device), period.shape),
        tightening=np.broadcast_to(strike_tightening(device, modal), period.shape),
        per_swing=PER_SWING,
    )


def stability_limit(device: Device, modal: ModalBeam) -> Value:
    """2/omega_max, us, of the stiffest state that a run is expected to meet; docs/theory.md.

    The tangent stiffness kappa + T S + EA/L (S q)(S q)^T + contact, with q the start or its mirror
    image, TENSION_REACH times as far, and T the tension there.
    """
    slope, identity = TENSION_REACH * modal.slope_start, np.eye(modal.load.shape[-1])
    stretch = dot(modal.slope_start, solve(modal.geometric, modal.slope_start))
    tension = modal.axial * (TENSION_REACH * TENSION_REACH - 1) * stretch
    tangent = modal.stiffness[..., np.newaxis] * identity + column(tension, 2) * modal.geometric
    tangent += column(2 * modal.axial, 2) * outer(slope, slope)
    contact = contact_stiffness(device, modal.residual)
    tangent += column(contact, 2) * outer(modal.midpoint, modal.midpoint)
    of_beam, of_mass = 2 / np.sqrt(eigenvalues(tangent)[..., -1]), 2 / device.mass_frequency
    return np.where(device.is_alone, of_beam, np.minimum(of_beam, of_mass))[()]


def arch_frequency(modal: ModalBeam) -> Value:
    """About how fast the arch swings with its axial stiffness, 1/us: kappa_1 + EA/L |S q0|^2."""
    arch = 2 * modal.axial * dot(modal.slope_start, modal.slope_start)
    return np.sqrt(modal.stiffness[..., 0] + arch)
