"""Shocks too weak to snap a device, by energy: whatever their shape, direction, gap and damping.

Let H be the energy of mass, spring, beam and contact, no part of which is below 0, and X = M y +
f.u, so that the pulse a does the work -a dX/dt a time, and damping only takes. With m the mass of
all (of a force on the midpoint |f|^2) and T <= H kinetic, (dX/dt)^2 <= 2 m T (Cauchy), and hence

    d sqrt(H)/dt <= |a| sqrt(m/2),                  H <= (m/2) (integral of |a|)^2.

The spring and the beam's bending alone hold X^2 <= 2 c H with c = M^2/K + f.bending^-1 f. By parts
the work is at most the largest |X| times all ups and downs of a, and so

    H <= 2 c (ups and downs of a)^2.

A snap takes H at least to the saddle, and to what bending alone asks for the displacement of the
midpoint. From the second shape the first bound holds for H above that shape, the least in its well;
for the second the mass holds X as said, and the beam, up to the saddle, by bending from the first.

Laws of a user's own leave that as it is if damping only takes and the contact has an energy that is
0 at first and nowhere below. A force over displacement has its integral, but no bending: the second
bound is not for it.
"""

from functools import partial

import numpy as np

from ..device.device import Value
from ..numerics.linalg import dot
from .cells import Rows
from .laws import Laws, curve
from .models import Follows
from .settings import FIRST


def least_amplitudes(model: Follows, rows: Rows, start: str = FIRST) -> np.ndarray:
    """Bound the N that can snap, multiples of g, (rows,): below, the energy does not suffice.

    model: of a batch; start: as in `Settings`
    """
    bounds = np.empty((2, len(model.device)))
    for mine, part in model.split(np.arange(bounds.shape[1])):
        if not _stores(part, start):
            bounds[:, mine] = 0.0
            continue
        device, modal, barrier = part.device, part.modal, part.barrier
        displacement = part.snap_target(FIRST)
        soft = dot(modal.midpoint, modal.midpoint / modal.stiffness) + modal.residual
        sag = device.mass * device.mass / device.spring
        of_beam = dot(modal.load, modal.load / modal.stiffness)
        energy: Value
        if part.laws and part.laws.force:
            energy, swing = barrier.energy, 0.0 * barrier.energy
        elif start == FIRST:
            energy = np.maximum(barrier.energy, displacement * displacement / (2 * soft))
            swing = np.sqrt(energy / (2 * (sag + of_beam)))
        else:
            energy = barrier.energy - part.second.energy
            reach = np.sqrt(2 * energy * sag) + np.sqrt(2 * barrier.energy * of_beam)
            swing = energy / (reach + abs(dot(modal.load, part.second.modes)))
        pushed = np.where(device.force, dot(modal.load, modal.load), device.beam.weight)
        least = np.sqrt(2 * energy / (device.mass + pushed)), swing
        bounds[:, mine] = np.array(least)[:, mine]
    # The least integral of |a|, um/us, and ups and downs of a, um/us^2.
    speed, swing = bounds[:, rows.device]
    facts = np.array([(pulse.gross_area, pulse.variation) for pulse in rows.pulses])
    gross, ups_and_downs = facts[rows.pulse].T
    a = np.maximum(speed * rows.f0 * 1e-6 / gross, swing / ups_and_downs)
    return a / np.asarray(model.device.gravity)[rows.device]


def _stores(model, start):
    """Whether the contact of a model has such an energy, as far as laws are looked at."""
    device, barrier, laws = model.device, model.barrier, model.laws or Laws()
    apart = np.max(device.gap + (0.0 if start == FIRST else barrier.first - barrier.second))
    for stiffness in np.unique(device.contact) if laws.contact else ():
        s, P = curve(partial(laws.contact, stiffness), device.beam.rise)
        if np.any(s * P < 0) or np.any(P[(s >= -apart) & (s <= 0)]):
            return False
    return laws.solver is None
