"""The tables of docs/validation.md: closed forms, published values, another solver.

./run python -m studies validation
"""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from snapmap import Study, simulate, statics, sweep
from snapmap.beam.cosines import buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import BucklingModes, displacement, find_barrier, push, roots
from snapmap.beam.modal import buckling
from snapmap.numerics.linalg import apply, eigh
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import bending_limit, command_device, few, stepped, with_beam
from .elastica import corners
from .peers.equations import equations_of
from .peers.scipy_ivp import compile_rate
from .tables import Table, write

HEAD = ["what", "reference", "ours", "difference"]
SHALLOW = ["rise/span", "largest force", "ours, %", "least force", "ours, %"]
SHALLOW += ["static threshold", "ours, %"]
SCALES = 1, 3, 6
"""Rise and thickness over the handout's, of beams with the same shallow equations."""
LARGE_Q = 300.0
F0, C = 1500.0, 25.0
TOLERANCE = 1e-9
"""Relative tolerance of the other integrator."""


def main():
    device = command_device()
    sections = {
        "statics": curved_beam(device),
        "spectra": spectra(),
        "made": stressed(device),
        "mass": mass(device),
    }
    tables = [Table(f"validation_{name}", HEAD, [*rows]) for name, rows in sections.items()]
    exact = ["device", "DOP853", "default steps", "small steps"]
    tables.append(Table("validation_solver", exact, [*thresholds(device)]))
    write("validation", *tables, Table("validation_shallow", SHALLOW, [*shallow(device)]))


def row(what, reference, value, digits=6):
    """Write a row, with the relative difference, or the absolute one if the reference is 0."""
    apart = f"{value / reference - 1:+.1e}" if reference else f"{value:+.1e}"
    return [what, f"{reference:.{digits}g}", f"{value:.{digits}g}", apart]


def curved_beam(device):
    """Yield rows of the statics of Qiu, Lang and Slocum's curved beam."""
    thin = with_beam(device, thickness=device.beam.rise / LARGE_Q)
    unit = thin.beam.stiffness_unit * thin.beam.rise
    path = statics(thin)
    rise = thin.beam.rise
    yield row("largest force", 740, path.largest_force / unit, 4)
    yield row("least force", -370, path.least_force / unit, 4)
    yield row("displacement of the saddle", 4 / 3, (rise - path.saddle) / rise)
    for name, basis, mu in (
        ("symmetric", symmetric_cosines(2), 4 * np.pi),
        ("antisymmetric", buckling_shapes(1), 2 * brentq(_tilts, 4.4, 4.6)),
    ):
        level, slope = _line(basis)
        exact = np.pi**2 * mu**2 / 2
        yield row(f"height, {name}", exact, level)
        yield row(f"slope, {name}", exact - 2 * np.pi**4, -slope)


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
    """Yield rows of buckling loads of elements, and frequencies of a beam in both bases."""
    elements = hermite_elements(12, free=True)
    mu = 2 * np.pi, 2 * brentq(_tilts, 4.4, 4.6), 4 * np.pi
    loads = eigh(elements.bending, elements.geometric)[0]
    for j, (root, load) in enumerate(zip(mu, loads, strict=False), start=1):
        yield row(f"buckling load {j}, elements", root * root, load, 8)
    for tension in (40.0, -20.0):
        exact = _frequencies(tension)
        for name, basis in (("elements", elements), ("shapes", buckling_shapes(12))):
            values = eigh(basis.bending + tension * basis.geometric, basis.mass)[0]
            what = f"frequency 3, T={tension:g}, {name}"
            yield row(what, exact[2], np.sqrt(values[2]), 7)


def _frequencies(tension):
    """The first three frequencies of a clamped beam under tension."""

    def clamped(omega):
        root = np.sqrt(tension * tension / 4 + omega * omega)
        p, q = np.sqrt(root - tension / 2), np.sqrt(root + tension / 2)
        both = 2 * p * q * (1 - np.cos(p) * np.cosh(q))
        return (both + (q * q - p * p) * np.sin(p) * np.sinh(q)) / np.cosh(q)

    grid = np.linspace(5, 160, 2000)
    signs = np.flatnonzero(np.diff(np.sign(clamped(grid))))
    return [brentq(clamped, grid[i], grid[i + 1], xtol=1e-13) for i in signs[:3]]


def stressed(device):
    """Yield rows of the stresses at which a beam changes its kind, and of its shapes.

    The references are roots of the cubic of the first cosine, by numpy.
    """
    beam = device.beam
    load = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    flat = load / beam.area
    yield row("flat beam buckles, MPa", flat, beam.buckling_stress)

    def force(stress):
        arch, push = 0.75 * beam.bistability**2, -stress * beam.area / load
        shapes = np.roots([arch, 0, 1 - arch - push, -1])
        return 1 - 1 / shapes[abs(shapes.imag) < 1e-7].real.min()

    lost = (2 / 3 * beam.bistability**2 - 4) * load / beam.area
    yield row("state 2 ends, MPa", lost, beam.most_stress)
    tilt = (brentq(_tilts, 4.4, 4.6) / np.pi) ** 2
    stays = brentq(lambda stress: force(stress) - tilt, -10, 0)
    stress = brentq(lambda s: replace(beam, residual_stress=s).stays_if_free - 0.5, -10, 0)
    yield row("free state 2 is stable, MPa", stays, stress)
    w2 = -beam.rise * (1 + np.sqrt(1 - 16 / (3 * beam.bistability**2))) / 2
    yield row("second shape, um", w2, beam.second_equilibrium)
    barrier = find_barrier(beam, hermite_elements(20))
    exact = find_barrier(beam, symmetric_cosines(20))
    yield row("saddle, um", -beam.rise / 3, beam.rise + barrier.midpoint)
    yield row("barrier, pJ", exact.energy, barrier.energy)


def mass(device):
    """Yield rows of the response of a mass alone, and of the energy lost by impacts."""
    alone = replace(device, gap=1e3)
    omega = np.sqrt(device.spring / device.mass)
    known = {"versed sine": (1.705, 1.0), "half sine": (1.768, 0.81)}
    for shape, (ratio, at) in few(known).items():
        peaks = []
        for cycles in np.linspace(0.9, 1.1, 9) * at:
            f0 = omega / (2 * np.pi * cycles) * 1e6
            run = simulate(Study(alone, Cosines(), pulse=shape, horizon=600.0), 100, f0, 0.0)
            rest = device.beam.rise + alone.gap
            still = 100 * device.gravity * device.mass / device.spring
            peaks.append(float(abs(run.z_mass - rest).max()) / still)
        most = np.polyval(np.polyfit(np.arange(9), peaks, 4), np.linspace(0, 8, 801)).max()
        yield row(f"response to a {shape}", ratio, most, 4)
    study = Study(device, Cosines(modes=3))
    cube = sweep(study, [700, 1000, 1500, 2200], [800, 3000], [0.0])
    yield row("energy lost over work", 0.0, float(cube.energy_error.max()))


def thresholds(device):
    """Yield rows of thresholds by DOP853, and of the differences of ours."""
    cases = {
        "as it is": device,
        "stress of -8 MPa, gap of 0.5 um": with_beam(
            replace(device, gap=0.5), residual_stress=-8.0
        ),
        "free, imperfection of 0.05 um": with_beam(device, free=1.0, imperfection=0.05),
    }
    for name, case in few(cases).items():
        model = build_model(case, Cosines(modes=3))
        near, short = _threshold(model), partial(_short_of_snap, model)
        exact = brentq(short, 0.995 * near, 1.005 * near, xtol=1e-6)
        fine = _threshold(stepped(model, 0.05 * bending_limit(model)))
        yield [name, f"{exact:.8g}", *(f"{N / exact - 1:+.1e}" for N in (near, fine))]


def shallow(device):
    """Yield rows of forces of the exact beam, in EI delta/L^3, and of how far ours are above, in %.

    The static threshold presses the mass to the largest force, against beam and spring; contact and
    spring are as stiff beside each beam as the handout's.
    """
    spring, soft = device.spring / device.beam.stiffness_unit, device.spring / device.contact
    for scale in few(SCALES):
        values = {key: scale * getattr(device.beam, key) for key in ("rise", "thickness")}
        beam = (steeper := with_beam(device, **values)).beam
        path, unit = statics(steeper), beam.stiffness_unit * beam.rise
        place, force = path.displacement.values[0] / beam.rise, path.force.values[0] / unit
        ours = [(place[at], force[at]) for at in (force.argmax(), force.argmin())]
        exact = [(at, each / unit) for at, each in corners(beam)]
        pairs = [(each[1], own[1]) for each, own in zip(exact, ours, strict=True)]
        pairs.append(tuple(top * (1 + soft) + spring * at for at, top in (exact[0], ours[0])))
        cells = [(f"{F:.5g}", f"{100 * (own / F - 1):.2f}") for F, own in pairs]
        yield [f"1/{beam.span / beam.rise:.0f}", *(cell for pair in cells for cell in pair)]


def _threshold(model):
    rows, settings = to_rows(0, F0, C), Run(horizon=0.0)
    return lowest_snap(Probe(model, rows, settings), (500.0, 2500.0), 1e-9).item()


def _short_of_snap(model, N):
    """Least distance of the midpoint from the snap during the pulse, um, by SciPy."""
    device, f0 = model.device, F0 * 1e-6
    (rate, w), rest = compile_rate(equations_of(model)), np.zeros(2 * model.modal.load.size + 2)
    how = {"rtol": TOLERANCE, "atol": 1e-10, "max_step": 0.5, "dense_output": True}
    shock = (N * device.gravity, f0, C)
    run = solve_ivp(rate, (0, 1 / f0), rest, "DOP853", args=shock, **how)
    target = model.barrier.second - model.barrier.first
    return min(w(x) for x in run.sol(np.linspace(0, 1 / f0, 4001)).T.copy()) - target
