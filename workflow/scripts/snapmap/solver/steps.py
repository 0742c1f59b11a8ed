"""The time step of a run, by question, pulse and device; and the limit of stability."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..beam.modal import ModalBeam, column, contact_stiffness
from ..device.device import Device
from ..numerics.linalg import dot, eigh, outer, solve
from ..values.kinds import Number
from .cells import Cells
from .settings import CALM, EDGE, FIRST, MOVE, QUESTIONS, SNAP, STAY

# ASSUME: chosen by measurement, see docs/accuracy.md.
OF_LIMIT = 0.8
"""Step of central differences over their limit of stability."""
# ASSUME: no run bends the beam further than this multiple of its start; see docs/accuracy.md.
TENSION_REACH = 1.25
FEWEST_STEPS = 16
"""Fewest steps in each swing of a pulse, whose sum then is exact to 1e-4."""
MORE = 1.5
"""Largest factor that multiplies the steps of the shortest pulses and fastest strikes."""
# ASSUME: the steps are chosen by measurement, see docs/accuracy.md.
PER_SWING = 500
"""Steps in each swing of a pulse that is slow for the device."""
SHORTEST = 0.15
"""Shortest step, in units of 1/omega of the arch; only FEWEST_STEPS and strikes ask for less."""
BLOWS = 400.0
"""Radians of the arch in a swing of a pulse up to which single blows of the mass decide, and EDGE
takes the shortest steps. For longer pulses its steps grow with the square of their length."""
LONGEST = {SNAP: 0.25, EDGE: 0.25, STAY: 0.25, CALM: 0.25, MOVE: 0.12}
"""Longest step, in units of 1/omega of the arch, by question."""
STAY_TURN = 0.6
"""Longest step for STAY, in the same units, over the number of times that a tension turns the
fastest mode faster than the slowest: 0.12 for 5 cosines. After a snap the beam is stretched."""
LONGEST_PRESSED = 2.5
"""Longest step for SNAP and EDGE if the mass is pressed on the beam, so that it cannot strike with
a run-up, and its spring does not hold it back."""
PRESSED_BY_LAW = 1.0
"""LONGEST_PRESSED of a beam of one mode under a law, which is found by iteration in each step."""
MOST, MOST_ALONE = 1100.0, 20_000.0
"""Most steps in each swing of a smooth pulse for SNAP and EDGE, as the beam follows a slow pulse
from rest to rest. MOST_ALONE is for a beam that snaps without the mass."""
HEAVY, HOLDS = 16.0, 5.0
"""HEAVY: mass over the beam's from which on MOST grows, with its fourth root. HOLDS: stiffness over
the clamped beam's, 192 EI/L^3, at which a spring holds the mass back from a beam that snaps."""
RUN_UP = 3.0
"""Rises that a mass may swing from which on its strike is fast, without stops; weaker shocks throw
it hardly faster than the beam follows."""
STRIKE_TURN = 2.0
"""Most radians per step by which the fastest mode turns under the tension of a strike, or of the
beam's own load; in longer steps the energy is conserved, but goes to the wrong modes."""
PULLED = 4.0
"""Factor on that load of a beam alone that a pulse pulls along -z: it is stretched for as long as
the pulse lasts, and comes back, so its fastest mode turns by half of STRIKE_TURN."""


@dataclass(frozen=True, eq=False)
class Steps:
    """The rule of the time steps of a batch; all but per_swing and factor are (devices,).

    longest: longest step by question, us
    shortest: step that resolves the device, however short the pulse, us
    blows: swing of a pulse up to which blows decide, us
    pressed: longest step for SNAP and EDGE if the mass is pressed on the beam, us
    returns: whether the mass may come back from a stop
    most: most steps in each swing of a smooth pulse, for SNAP and EDGE
    tightening, own_tightening: as in `strike_tightening`, of the mass, and of the beam by its own
        load, 1/(um us)
    arch: frequency of the arch, rad/us
    per_swing: steps in each swing of a pulse that is slow for the device
    factor: multiplies every step
    """

    longest: Mapping[str, np.ndarray]
    shortest: np.ndarray
    blows: np.ndarray
    pressed: np.ndarray
    returns: np.ndarray
    most: np.ndarray
    tightening: np.ndarray
    own_tightening: np.ndarray
    arch: np.ndarray
    per_swing: float
    factor: float = 1.0

    def of(
        self,
        cells: Cells,
        question: str,
        speed: np.ndarray | float = 0.0,
        shaken: np.ndarray | float = 0.0,
    ) -> np.ndarray:
        """Return the step of each cell, us, in the cells' shape.

        speed, shaken: as `strikes` returns them
        """
        forms = np.array([(p.is_flat, p.is_smooth, p.strikes) for p in cells.pulses])
        flat, smooth, strikes = forms.T[:, cells.pulse]
        swing = 1 / (np.array([p.swings for p in cells.pulses])[cells.pulse] * cells.f0)
        resolved, shortest = swing / self.per_swing, self.shortest[cells.device]
        if question == EDGE:
            of_blows = (swing / self.blows[cells.device]) ** 2
            resolved = np.minimum(resolved, of_blows * shortest)
        longest = self.longest[question][cells.device]
        if question in (SNAP, EDGE):
            rests = ~(strikes | self.returns[cells.device] | (speed > 0))
            slow = np.where(smooth, swing / self.most[cells.device], 0.0)
            longest = np.where(rests, np.maximum(self.pressed[cells.device], slow), longest)
        step = np.minimum(longest, np.maximum(resolved, shortest))
        factor = min(self.factor, MORE)
        most = np.where(flat, np.inf, factor * swing / FEWEST_STEPS)
        step = np.minimum(self.factor * step, most)
        own = shaken * self.own_tightening[cells.device] * shaken_speed(self.arch, cells)
        turn = step * np.sqrt(self.tightening[cells.device] * speed + own)
        return step / np.maximum(turn / (factor * STRIKE_TURN), 1.0)

    def times(self, factor: float) -> "Steps":
        """Return the rule with every step multiplied by `factor`, or by MORE for short pulses."""
        return replace(self, factor=factor * self.factor)

    def of_one_mode(self) -> "Steps":
        """Return the rule for a beam of one mode under a law: no faster mode asks for less."""
        pressed = np.minimum(self.pressed, PRESSED_BY_LAW / self.arch)
        shortest = self.longest[EDGE]
        return replace(self, shortest=shortest, pressed=pressed, most=np.inf * self.most)

    def pick(self, which: int | np.ndarray) -> "Steps":
        """Return the rule of a device of the batch, or of several."""
        which = np.atleast_1d(which)
        longest = {question: step[which] for question, step in self.longest.items()}
        columns = {key: a[which] for key, a in vars(self).items() if isinstance(a, np.ndarray)}
        return replace(self, longest=longest, **columns)


def fixed(dt: np.ndarray) -> Steps:
    """Return the rule of a constant step of each device, us, (devices,), but for short pulses."""
    return Steps(
        longest=dict.fromkeys(QUESTIONS, dt),
        shortest=dt,
        blows=dt,
        pressed=dt,
        returns=np.zeros(dt.shape, bool),
        most=np.full(dt.shape, np.inf),
        tightening=np.zeros(dt.shape),
        own_tightening=np.zeros(dt.shape),
        arch=np.ones(dt.shape),
        per_swing=FEWEST_STEPS,
    )


def spring_share(device: Device) -> Number:
    """Return, from 0 to 1, how far the spring holds the mass back, so that the beam snaps alone."""
    over = device.spring / (HOLDS * 192 * device.beam.stiffness_unit)
    cube = over * over * over
    return np.where(device.is_alone, 1.0, cube * cube / (1 + cube * cube))


def most_steps(device: Device) -> Number:
    """Return the most steps that a swing of a smooth pulse needs, however slow it is."""
    beam, share = device.beam, spring_share(device)
    heavy = 1 + device.mass / (HEAVY * beam.mass_per_length * beam.span)
    return (1 - share) * MOST * np.sqrt(np.sqrt(heavy)) + share * MOST_ALONE


def strike_tightening(mass: Number, modal: ModalBeam) -> Number:
    """Return omega^2 / v of the fastest mode under the tension of a strike at speed v, 1/(um us).

    The tension T = axial Q is that of a beam whose stretch has taken the energy of the mass, ng,
    axial Q^2/4 = M v^2/2. Bending is left out: the kernel turns a mode by that exactly.
    """
    return np.sqrt(2 * mass * modal.axial) * modal.geometric[..., -1, -1]


def strikes(device: Device, cells: Cells, start: str) -> tuple[np.ndarray, np.ndarray]:
    """Bound the speed at which a mass strikes the beam with a run-up, um/us, in the cells' shape.

    It is 0 but in runs from the second shape, where no mass rests on the beam, and of a mass that
    a shock throws against its stops, or so far away that it may swing by RUN_UP rises.
    Also returns by how much the beam's own load counts: with stops, and after such a swing, only
    shocks snap it that are far stronger than those that snap another beam, as along -z one alone.
    """
    facts = np.array([(pulse.strikes, pulse.pulls) for pulse in cells.pulses])
    may_strike, pulled = np.moveaxis(facts[cells.pulse], -1, 0)
    stopped = np.broadcast_to(np.atleast_1d(device.has_stops)[cells.device], pulled.shape)
    load = stopped + PULLED * (pulled & np.atleast_1d(device.is_alone)[cells.device])
    from_second = np.full(pulled.shape, start != FIRST)
    if not np.any(may_strike | from_second):
        return np.zeros(pulled.shape), load
    speed = largest_speed(device, cells)
    swing = speed / np.atleast_1d(device.mass_frequency)[cells.device]
    far = pulled & (swing > np.atleast_1d(RUN_UP * device.beam.rise)[cells.device])
    return np.where(from_second | may_strike & stopped | far, speed, 0.0), np.maximum(load, far)


def largest_speed(device: Device, cells: Cells) -> np.ndarray:
    """Bound the speed of the undamped mass on its spring, um/us; 0 without a mass."""
    speed = shaken_speed(np.atleast_1d(device.mass_frequency), cells)
    return np.where(np.atleast_1d(device.is_alone)[cells.device], 0.0, speed)


def shaken_speed(frequency: np.ndarray, cells: Cells) -> np.ndarray:
    """Bound the speed of an oscillator that pulses shake, um/us, in the cells' shape.

    frequency: rad/us, (devices,)
    The integral of |a| is a bound, and so is the total variation of a over the frequency.
    """
    facts = np.array([(pulse.gross_area, pulse.variation) for pulse in cells.pulses])
    gross, variation = facts.T[:, cells.pulse]
    swing = variation / frequency[cells.device]
    return abs(cells.amplitude) * np.minimum(gross / cells.f0, swing)


def explicit_steps(device: Device, modal: ModalBeam) -> Steps:
    """Return the rule of central differences, a constant step for each device."""
    return fixed(np.atleast_1d(OF_LIMIT * stability_limit(device, modal)))


def steps_of(device: Device, modal: ModalBeam) -> Steps:
    """Return the rule of the kernels for a device or a batch."""
    period = np.atleast_1d(1 / arch_frequency(modal))
    crosses = np.greater(device.gap, 0) & np.isfinite(device.gap)
    share = np.where(crosses, 1.0, spring_share(device))
    pressed = LONGEST_PRESSED + (LONGEST[SNAP] - LONGEST_PRESSED) * share
    slowest, fastest = np.sqrt(modal.geometric[..., 0, 0]), np.sqrt(modal.geometric[..., -1, -1])
    # A law of the force leaves no tension, and a single mode.
    stay = STAY_TURN * np.where(fastest > 0, slowest, 1.0) / np.where(fastest > 0, fastest, 1.0)
    longest = LONGEST | {STAY: np.minimum(LONGEST[STAY], stay)}
    return Steps(
        longest={question: turn * period for question, turn in longest.items()},
        shortest=SHORTEST * period,
        blows=BLOWS * period,
        pressed=pressed * period,
        returns=np.broadcast_to(device.has_stops, period.shape),
        most=np.broadcast_to(most_steps(device), period.shape),
        tightening=np.broadcast_to(strike_tightening(device.mass, modal), period.shape),
        own_tightening=np.broadcast_to(strike_tightening(device.beam.weight, modal), period.shape),
        arch=1 / period,
        per_swing=PER_SWING,
    )


def stability_limit(device: Device, modal: ModalBeam) -> Number:
    """Return 2/omega_max, us, of the stiffest state that a run is expected to meet; docs/theory.md.

    The tangent stiffness there is kappa + T S + EA/L (S q)(S q)^T + contact, with q = TENSION_REACH
    times the start or its mirror image, and the tension T at q.
    """
    slope, identity = TENSION_REACH * modal.slope_start, np.eye(modal.load.shape[-1])
    stretch = dot(modal.slope_start, solve(modal.geometric, modal.slope_start))
    tension = modal.axial * (TENSION_REACH * TENSION_REACH - 1) * stretch
    tangent = modal.stiffness[..., np.newaxis] * identity + column(tension, 2) * modal.geometric
    tangent += column(2 * modal.axial, 2) * outer(slope, slope)
    contact = contact_stiffness(device, modal.residual)
    tangent += column(contact, 2) * outer(modal.midpoint, modal.midpoint)
    of_beam, of_mass = 2 / np.sqrt(eigh(tangent)[0][..., -1]), 2 / device.mass_frequency
    return np.where(device.is_alone, of_beam, np.minimum(of_beam, of_mass))[()]


def arch_frequency(modal: ModalBeam) -> Number:
    """Estimate omega of the arch, 1/us: omega^2 = kappa_1 + EA/L |S q0|^2."""
    arch = 2 * modal.axial * dot(modal.slope_start, modal.slope_start)
    return np.sqrt(modal.stiffness[..., 0] + arch)
