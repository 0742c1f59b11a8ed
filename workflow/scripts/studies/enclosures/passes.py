"""All equilibria of a beam's modal form up to an energy, enclosed; so its barrier, from below.

In buckling modes, K v_j = N_j S v_j and v_i.S v_j = 1 for i = j alone, the energy is

    sum N_j (q_j - s_j)^2 / 2 + (N/A)^2 A/4 + rest,    N/A = c - sum q_j^2,

A = EA/2L, and equilibria have (N_j - N) q_j = N_j s_j: they are roots of N/A - c + sum q_j^2 in
the axial force alone, but close to a load N_j, where q_j is what the stretch leaves for it. The
same holds on the plane of all shapes with a given midpoint, with other numbers. All of it is done
with balls, so that no equilibrium is missed.
"""

from typing import NamedTuple

from flint import arb, arb_mat

CLOSE = 2.0**-80
"""Of a load N_j, relative: there q_j is what the stretch leaves."""
NARROW = 2.0**-120
ABOVE = 2.0**-20
"""Up to this share above the stored barrier equilibria are looked for."""


class Energy(NamedTuple):
    """In buckling modes; loads ascending, and s_j: (k,); the others numbers of flint."""

    loads: list
    s: list
    axial: arb
    c: arb
    rest: arb


class Found(NamedTuple):
    """What may be an equilibrium: its energy, a ball, and whether it can be shown to be stable."""

    energy: arb
    stable: bool


def of_beam(modal):
    """The energy of a beam from its modal form of one device, numbers as they are stored."""
    K, S, slope = _matrices(modal)
    q0 = S.inv() * slope
    whole = (q0.transpose() * slope)[0, 0]
    return _in_buckling_modes(K, S, q0, arb(float(modal.axial)), whole, arb(0))


def at_midpoint(modal, w):
    """The same of all shapes whose midpoint is displaced by w, um."""
    K, S, slope = _matrices(modal)
    e, k, q0 = [arb(float(c)) for c in modal.midpoint], len(modal.midpoint), S.inv() * slope
    pivot = max(range(k), key=lambda i: abs(float(e[i])))
    column = arb_mat([[c] for c in e])
    soft = S.inv() * column
    reached = arb(float(w)) + (column.transpose() * q0)[0, 0]
    # q = foot + Z z with Z within the plane, and the foot S-orthogonal to it.
    foot = soft * (reached / (column.transpose() * soft)[0, 0])
    others = [i for i in range(k) if i != pivot]
    Z = arb_mat(k, k - 1)
    for j, i in enumerate(others):
        Z[i, j], Z[pivot, j] = 1, -e[i] / e[pivot]
    K_z, S_z, apart = Z.transpose() * K * Z, Z.transpose() * S * Z, q0 - foot
    z0 = K_z.inv() * (Z.transpose() * K * apart)
    axial, left = arb(float(modal.axial)), apart - Z * z0
    rest = (left.transpose() * K * apart)[0, 0] / 2
    c = (q0.transpose() * slope)[0, 0] - (foot.transpose() * S * foot)[0, 0]
    return _in_buckling_modes(K_z, S_z, z0, axial, c, rest)


def _matrices(modal):
    k = len(modal.midpoint)
    K = arb_mat([[float(modal.stiffness[i]) if i == j else 0 for j in range(k)] for i in range(k)])
    half = arb_mat([[float(c) / 2 for c in row] for row in modal.geometric])
    return K, half + half.transpose(), arb_mat([[float(c)] for c in modal.slope_start])


def _in_buckling_modes(K, S, q0, axial, c, rest):
    values, right = (S.inv() * K).eig(right=True, algorithm="rump")
    order = sorted(range(len(values)), key=lambda j: float(values[j].real))
    loads, s = [], []
    for j in order:
        v = arb_mat([[right[i, j].real] for i in range(len(values))])
        size = (v.transpose() * S * v)[0, 0]
        loads.append(values[j].real)
        s.append((v.transpose() * S * q0)[0, 0] / size.sqrt())
    return Energy(loads, s, axial, c, rest)


def equilibria(energy, most):
    """All that may be equilibria of no more than `most` pJ, tension left out or not; `Found`s."""
    limit, found = (4 * energy.axial * abs(most)).sqrt().upper(), []
    unstretched = energy.c - sum(s * s for s in energy.s)
    if not unstretched > 0:
        found.append(Found(energy.rest, True))
    edges = [-limit]
    for j, load in enumerate(energy.loads):
        about = load + load * arb(0, CLOSE)
        found += _at_load(energy, j, about)
        edges += [about.lower(), about.upper()]
    edges.append(max(limit, 2 * edges[-1]))
    for low, high in zip(edges[::2], edges[1::2], strict=True):
        found += _between(energy, low, high, most)
    return [one for one in found if not one.energy > most]


def _stored(energy, N, q):
    apart = zip(energy.loads, q, energy.s, strict=True)
    bending = sum((load * (c - s) * (c - s) for load, c, s in apart), arb(0))
    return energy.rest + bending / 2 + N * N / (4 * energy.axial)


def _coordinates(energy, N):
    return [s * load / (load - N) for s, load in zip(energy.s, energy.loads, strict=True)]


def _at_load(energy, j, N):
    """What may be with N about the j-th load, on either side."""
    q = _coordinates(energy, N)
    others = sum((c * c for i, c in enumerate(q) if i != j), arb(0))
    left = energy.c - N / energy.axial - others
    size = arb(left.abs_upper()).sqrt()
    if left < 0 or abs(energy.s[j]) > 2 * CLOSE * size:
        return []
    root = left.sqrt() if left > 0 else arb(0).union(size)
    sides = [[*q[:j], side, *q[j + 1 :]] for side in (root, -root)]
    return [Found(_stored(energy, N, q), False) for q in sides]


def _between(energy, low, high, most):
    """What may be with N between two places without a load between them."""
    todo, found = [(low, high)], []
    while todo:
        low, high = todo.pop()
        N = low.union(high)
        q = _coordinates(energy, N)
        left = N / energy.axial - energy.c + sum(c * c for c in q)
        if left > 0 or left < 0 or _stored(energy, N, q) > most:
            continue
        slope = 1 / energy.axial
        slope += sum(2 * c * c / (load - N) for c, load in zip(q, energy.loads, strict=True))
        below = sum(1 for load in energy.loads if not load > N)
        narrow = high - low < NARROW * (abs(low) + abs(high) + energy.loads[0] * NARROW)
        if narrow:
            stable = below == 0 or (below == 1 and slope < 0)
            found.append(Found(_stored(energy, N, q), stable))
            continue
        middle = ((low + high) / 2).mid()
        todo += [(low, middle), (middle, high)]
    return found


def lowest(modal, barrier):
    """What encloses the energy of the lowest pass, and the least of the plane's, from below, pJ."""
    most = arb(float(barrier.energy)) * (1 + ABOVE)
    found = [one.energy for one in equilibria(of_beam(modal), most) if not one.stable]
    plane = [one.energy for one in equilibria(at_midpoint(modal, barrier.midpoint), most)]
    found, plane = ([*energies, most] for energies in (found, plane))
    first = min(one.lower() for one in found).union(min(one.upper() for one in found))
    return first, min(one.lower() for one in plane)


def floor(modal, barrier):
    """No more than the energy of any pass, and of any shape with the saddle's midpoint, pJ."""
    first, plane = lowest(modal, barrier)
    return min(first.lower(), plane)
