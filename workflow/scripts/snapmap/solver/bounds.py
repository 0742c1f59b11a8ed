"""Lower bounds of N by energy: weaker shocks cannot snap a device, whatever its gap and damping.

Let H >= 0 be the energy of mass, spring, beam and contact, each of which is >= 0, and X = M y +
f.u. The pulse a does work at the rate -a dX/dt, and damping only takes energy. With the total mass
m (|f|^2 for a force on the midpoint) and the kinetic energy T <= H, (dX/dt)^2 <= 2 m T by Cauchy,
and hence

    d sqrt(H)/dt <= |a| sqrt(m/2),                  H <= (m/2) (integral of |a|)^2.

Spring and bending alone imply X^2 <= 2 c H with c = M^2/K + f.bending^-1 f. Integrated by parts,
the work is at most the largest |X| times the total variation of a, and so

    H <= 2 c (total variation of a)^2.

For a snap H must reach the energy of the saddle, and the bending energy of the displacement of the
midpoint. From the second shape the first bound holds for H above that shape, the least in its well.
For the second bound the mass limits X as above, and the beam, up to the saddle, by its bending from
the first shape.

A user's laws keep these bounds if damping only takes energy, and the contact has an energy that is
0 at first and nowhere negative. A law of force has its integral as energy, but no bending, and so
no second bound.
"""

from functools import partial

import numpy as np

from ..numerics.linalg import dot
from ..values.kinds import Number
from .cells import Rows
from .laws import Laws, curve, of_user
from .models import Follows
from .settings import FIRST

SHARES = np.linspace(-1.0, 1.0, 16)
"""Velocities and places at which a law of damping is asked whether it drives, over the largest."""


def least_amplitudes(model: Follows, rows: Rows, start: str = FIRST) -> np.ndarray:
    """Return the N, in multiples of g, (rows,), below which no shock has the energy for a snap.

    model: of a batch, to which the rows belong; start: as in `Run`
    """
    bounds = np.empty((2, len(model.device)))
    for mine, part in model.split(np.arange(bounds.shape[1])):
        if not _stores(part, rows, start):
            bounds[:, mine] = 0.0
            continue
        device, modal, barrier = part.device, part.modal, part.barrier
        displacement = part.snap_target(FIRST)
        soft = dot(modal.midpoint, modal.midpoint / modal.stiffness) + modal.residual
        sag = device.mass * device.mass / device.spring
        of_beam = dot(modal.load, modal.load / modal.stiffness)
        energy: Number
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
    # The least integral of |a|, um/us, and the least total variation of a, um/us^2.
    speed, swing = bounds[:, rows.device]
    facts = np.array([(pulse.gross_area, pulse.variation) for pulse in rows.pulses])
    gross, variation = facts[rows.pulse].T
    a = np.maximum(speed * rows.f0 * 1e-6 / gross, swing / variation)
    return a / np.asarray(model.device.gravity)[rows.device]


def _stores(model, rows, start):
    """Return whether the laws of contact and damping are, where sampled, as the bounds need them.

    The contact has an energy, and with no more energy than that of the saddle no mass is driven.
    """
    device, barrier, laws = model.device, model.barrier, model.laws or Laws()
    apart = np.max(device.gap + (0.0 if start == FIRST else barrier.first - barrier.second))
    for stiffness in np.unique(device.contact) if laws.contact else ():
        s, P = curve("contact", partial(laws.contact, stiffness), device.beam.rise)
        if np.any(s * P < 0) or np.any(P[(s >= -apart) & (s <= 0)]):
            return False
    if laws.damping:
        fastest, farthest = (
            np.sqrt(2 * np.max(barrier.energy / inertia))
            for inertia in (device.mass, device.spring)
        )
        C = rows.C * np.atleast_1d(device.damper_factor)[rows.device]
        velocities, places = fastest * SHARES * abs(SHARES), farthest * SHARES
        with of_user("damping"):
            return all(
                velocity * laws.damping(damping, velocity, place) >= 0
                for damping in np.unique(C).tolist()
                for velocity in velocities.tolist()
                for place in places.tolist()
            )
    return True
