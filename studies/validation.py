"""Prints the first part of docs/validation.md: closed forms, published values, another code.

./run python -m studies validation
"""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from snapmap import load_device, simulate, statics, sweep
from snapmap.beam.cosines import buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import BucklingModes, displacement, find_barrier, push, roots
from snapmap.beam.modal import buckling, contact_stiffness
from snapmap.files.text import table
from snapmap.numerics.linalg import apply, eigh
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import lowest_snap

from .common import ROOT, bending_limit, few, stepped

HEAD = ["what", "source", "theirs", "ours", "difference"]
LARGE_Q = 300.0
F0, C = 1500.0, 25.0
TOLERANCE = 1e-9
"""Of the other integrator; thresholds are refined to a hundredth of what its runs then resolve."""
TEXT = """\
# Validation

Exact solutions, published values and other codes beside ours. This command prints the first part;
the second was measured once, by a study that the tag `before-cut` keeps:

    ./run python -m studies validation

**No measured device has been compared.** These tables show that the equations are solved, not that
a device obeys them; the [second part](#other-codes) shows what the equations leave out. A
comparison with a device needs its dimensions as made; the beam's first frequency before assembly;
mass and spring, or their frequency; gap and gas pressure; the acceleration at the die; and, at each
level, how many shocks snapped the device and how many did not.

## Statics of the curved beam

Force on the midpoint in $EI\\delta/L^3$, displacement in $\\delta$. Values for large $Q$ and the
lines of three modes are those of Qiu, Lang and Slocum (J. Microelectromech. Syst. 13, 2004, 137),
as others quote them. With the axial force at a buckling load $\\mu^2EI/L^2$ the first cosine gives
$F=\\tfrac{{\\pi^2}}2\\mu^2-(\\tfrac{{\\pi^2}}2\\mu^2-2\\pi^4)\\Delta$: for $\\mu=4\\pi$ the printed
$8\\pi^4-6\\pi^4\\Delta$, for the antisymmetric $\\mu=8.9868$ it is
$4.09\\pi^4-2.09\\pi^4\\Delta$; the printed $4.18\\pi^4-2.18\\pi^4\\Delta$ is 2 and 4 % larger.
The largest force for $Q\\to\\infty$, with the axial force $16\\pi^2$ and cosines $u_n$, $n$ odd:
$u_1=(2F-1558.5)/2337.8$, $u_3=-2F/35067$, $u_5=-2F/409119$ and no stretch,
$u_1^2+u_1+9u_3^2+25u_5^2=0$, give $F=758.7$, as ours; 740 is quoted.

{statics}

## Buckling and frequencies

Buckling loads have $\\mu=2\\pi,\\ 4\\pi$ and $\\tan\\mu/2=\\mu/2$. Frequencies of the clamped
beam with tension $T$ are the roots of $2pq(1-\\cos p\\cosh q)+(q^2-p^2)\\sin p\\sinh q=0$ with
$p^2,q^2=\\mp\\tfrac T2+\\sqrt{{T^2/4+\\omega^2}}$, in $EI/L^2$ and $\\sqrt{{EI/\\rho AL^4}}$.

{spectra}

## Residual stress, gap and tilt, at the handout's device

{made}

## The mass alone, and elastic impacts

Across a gap that is never closed, the mass is an oscillator. Impacts are elastic: the energy of
mass, spring, contact and beam is the work of the pulse.

{mass}

## Thresholds against another integrator

The same equations of 3 cosines by scipy's DOP853 at a relative tolerance of {tolerance:g}; f0 =
{f0:g} Hz, C = {C:g}. Small steps are a twentieth of the limit. [Accuracy](accuracy.md) compares
with heyoka's Taylor method.

{thresholds}
"""


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    sections = {
        "statics": curved_beam(device),
        "spectra": spectra(),
        "made": made(device),
        "mass": mass(device),
        "thresholds": thresholds(device),
    }
    tables = {name: table(HEAD, rows) for name, rows in sections.items()}
    print(TEXT.format(**tables, tolerance=TOLERANCE, f0=F0, C=C), end="")


def row(what, source, theirs, ours, digits=6):
    """A row; the difference relative, where theirs is not 0."""
    apart = f"{ours / theirs - 1:+.1e}" if theirs else f"{ours:+.1e}"
    return [what, source, f"{theirs:.{digits}g}", f"{ours:.{digits}g}", apart]


def curved_beam(device):
    """Qiu, Lang and Slocum's curved beam."""
    thin = replace(device, beam=replace(device.beam, thickness=device.beam.rise / LARGE_Q))
    unit = thin.beam.stiffness_unit * thin.beam.rise
    path = statics(thin)
    rise, quoted = thin.beam.rise, "Qiu et al."
    yield row("largest force", quoted, 740, path.largest_force / unit, 4)
    yield row("least force", quoted, -370, path.least_force / unit, 4)
    yield row("displacement of the saddle", quoted, 4 / 3, (rise - path.saddle) / rise)
    for name, basis, mu in (
        ("symmetric", symmetric_cosines(2), 4 * np.pi),
        ("antisymmetric", buckling_shapes(1), 2 * brentq(_tilts, 4.4, 4.6)),
    ):
        level, slope = _line(basis)
        exact = np.pi**2 * mu**2 / 2
        yield row(f"level of the {name} path", "derived above", exact, level)
        yield row(f"slope of the {name} path", "derived above", exact - 2 * np.pi**4, -slope)


def _tilts(x):
    return np.sin(x) - x * np.cos(x)


def _line(basis):
    """Level and slope of the straight path on which the axial force stays at the second load."""
    loads, shapes = buckling(basis)
    vectors = apply(basis.geometric, basis.start), basis.load, basis.midpoint
    vectors = (apply(shapes.T, vector) for vector in vectors)
    columns = (column[:1, np.newaxis] for column in (loads, *vectors))
    first = BucklingModes(*columns, axial=6 * LARGE_Q**2, residual=0.0)
    N = loads[1:2]
    constant, slope = push(first, N)
    ends = np.concatenate(roots(first, N, constant, slope))
    places = np.array([displacement(first, constant + slope * P).item() for P in ends])
    falls = np.diff(ends)[0] / np.diff(places)[0]
    return ends[0] - falls * places[0], falls


def spectra():
    """Buckling loads of elements, and frequencies of the straight beam in both bases."""
    elements = hermite_elements(12, free=True)
    mu = 2 * np.pi, 2 * brentq(_tilts, 4.4, 4.6), 4 * np.pi
    loads = eigh(elements.bending, elements.geometric)[0]
    for j, (one, ours) in enumerate(zip(mu, loads, strict=False), start=1):
        yield row(f"buckling load {j}, 12 elements", "closed form", one * one, ours, 8)
    for tension in (40.0, -20.0):
        exact = _frequencies(tension)
        for name, basis in (("12 shapes", buckling_shapes(12)), ("12 elements", elements)):
            values = eigh(basis.bending + tension * basis.geometric, basis.mass)[0]
            for j in (0, 2):
                what = f"frequency {j + 1} at T = {tension:g}, {name}"
                yield row(what, "characteristic equation", exact[j], np.sqrt(values[j]), 7)


def _frequencies(tension):
    """The first three of a clamped beam under tension."""

    def clamped(omega):
        root = np.sqrt(tension * tension / 4 + omega * omega)
        p, q = np.sqrt(root - tension / 2), np.sqrt(root + tension / 2)
        both = 2 * p * q * (1 - np.cos(p) * np.cosh(q))
        return (both + (q * q - p * p) * np.sin(p) * np.sinh(q)) / np.cosh(q)

    grid = np.linspace(5, 160, 2000)
    signs = np.flatnonzero(np.diff(np.sign(clamped(grid))))
    return [brentq(clamped, grid[i], grid[i + 1], xtol=1e-13) for i in signs[:3]]


def made(device):
    """Where stresses change what a beam is, from the cubic of its first cosine, by numpy."""
    beam = device.beam
    load = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    flat = load / beam.area
    yield row("buckling of the flat beam, MPa", "4 pi^2 EI / A L^2", flat, beam.buckling_stress)

    def force(stress):
        arch, push = 0.75 * beam.bistability**2, -stress * beam.area / load
        found = np.roots([arch, 0, 1 - arch - push, -1])
        return 1 - 1 / found[abs(found.imag) < 1e-7].real.min()

    lost = (2 / 3 * beam.bistability**2 - 4) * load / beam.area
    yield row("tension that ends state 2, MPa", "c = -1/3 in the cubic", lost, beam.most_stress)
    tilt = (brentq(_tilts, 4.4, 4.6) / np.pi) ** 2
    stays = brentq(lambda stress: force(stress) - tilt, -10, 0)
    ours = brentq(lambda s: replace(beam, residual_stress=s).stays_if_free - 0.5, -10, 0)
    yield row("stress at which free state 2 is stable, MPa", "axial force of tilting", stays, ours)
    w2 = -beam.rise * (1 + np.sqrt(1 - 16 / (3 * beam.bistability**2))) / 2
    yield row("second shape, um", "closed form", w2, beam.second_equilibrium)
    barrier = find_barrier(beam, hermite_elements(20))
    exact = find_barrier(beam, symmetric_cosines(20))
    yield row("saddle, um", "-rise/3", -beam.rise / 3, beam.rise + barrier.midpoint)
    yield row("barrier of 20 elements, pJ", "20 cosines", exact.energy, barrier.energy)


def mass(device):
    """The mass alone under pulses, and the energy of impacts."""
    alone = replace(device, gap=1e4)
    omega = np.sqrt(device.spring / device.mass)
    known = {"versed sine": (1.705, 1.0), "half sine": (1.768, 0.81)}
    for shape, (ratio, at) in few(known).items():
        peaks = []
        for cycles in np.linspace(0.9, 1.1, 9) * at:
            f0 = omega / (2 * np.pi * cycles) * 1e6
            run = simulate(alone, 100, f0, 0.0, model="cosines", horizon=600.0, pulse=shape)
            rest = device.beam.rise + alone.gap
            still = 100 * device.gravity * device.mass / device.spring
            peaks.append(float(abs(run.z_mass - rest).max()) / still)
        ours = np.polyval(np.polyfit(np.arange(9), peaks, 4), np.linspace(0, 8, 801)).max()
        yield row(f"largest response to a {shape}", "shock spectra", ratio, ours, 4)
    cube = sweep(device, [700, 1000, 1500, 2200], [800, 3000], [0.0], model="cosines", modes=3)
    worst = float(cube.energy_error.max())
    yield row("energy lost in elastic impacts, over the pulse's work", "none", 0.0, worst)


def thresholds(device):
    """Thresholds by another integrator."""
    cases = {
        "as it is": device,
        "stress of -8 MPa, gap of 0.5 um": replace(
            device, gap=0.5, beam=replace(device.beam, residual_stress=-8.0)
        ),
        "free, imperfection of 0.05 um": replace(
            device, beam=replace(device.beam, free=1.0, imperfection=0.05)
        ),
    }
    for name, one in few(cases).items():
        model = build_model(one, "cosines", modes=3)
        near = _own(model)
        theirs = brentq(lambda N, m=model: _other(m, N), 0.995 * near, 1.005 * near, xtol=1e-6)
        yield row(f"{name}, as shipped", "DOP853", theirs, near, 8)
        fine = stepped(model, 0.05 * bending_limit(model))
        yield row(f"{name}, small steps", "DOP853", theirs, _own(fine), 8)


def _own(model):
    rows, settings = to_rows(0, F0, C), Settings(0.0)
    return lowest_snap(model, rows, (500.0, 2500.0), settings, 1e-9).item()


def _other(model, N):
    """How far short of the snap a run of N stays, um, to the end of the pulse; by scipy."""
    device, modal = model.device, model.modal
    k, contact = modal.load.size, float(contact_stiffness(device, modal.residual))
    shock, f0 = make_pulse(), F0 * 1e-6
    target = model.barrier.second - model.barrier.first

    def overlap(x):
        return contact * max(0.0, modal.midpoint @ x[:k] - x[k] - device.gap)

    def rate(t, x):
        p, y, v, y_rate = x[:k], x[k], x[k + 1 : -1], x[-1]
        a = N * device.gravity * shock.at(np.array([f0 * t]))[0]
        slope = modal.geometric @ p + modal.slope_start
        force = -modal.axial * p @ (slope + modal.slope_start)
        P = overlap(x)
        pull = force * slope - modal.stiffness * p - modal.load * a - modal.midpoint * P
        y_pull = (P - device.spring * y - C * y_rate) / device.mass - a
        return np.concatenate([v, [y_rate], pull, [y_pull]])

    def above(_, x):
        return modal.midpoint @ x[:k] - modal.residual * overlap(x) - target

    times = np.linspace(0, 1 / f0, 4001)
    how = {"rtol": TOLERANCE, "atol": 1e-10, "max_step": 0.5, "dense_output": True}
    run = solve_ivp(rate, (0, 1 / f0), np.zeros(2 * k + 2), "DOP853", **how)
    return min(above(0, x) for x in run.sol(times).T)


if __name__ == "__main__":
    main()
