"""A clamped beam as corotational elements of OpenSeesPy: geometrically exact, and not ours.

Units as in the package: um, ng, us, uN. Half of the beam, its midpoint guided, or the whole of it.
"""

import ctypes
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from snapmap.device import Beam, Device

STEPS = 1600
"""Of the midpoint along a path."""
SNAPPED = 1.6
"""Way of the midpoint, in the rise, that no beam comes back from while it is pressed."""
SERIES, PATTERN, TURN = 1, 1, 1
SPRING, CONTACT = 1001, 1002


def load():
    """The module; ImportError, in one line, if it is not there or its libraries are not."""
    wheel = find_spec("openseespylinux")
    if not wheel:
        raise ImportError("OpenSeesPy is not installed: see the group bench in pyproject.toml")
    try:
        # It brings a libblas that its own libraries do not find.
        ctypes.CDLL(str(Path(wheel.origin).parent / "lib" / "libblas.so.3"))
        return import_module("openseespylinux.opensees")
    except (OSError, RuntimeError) as error:
        cause = error.__context__ or error
        raise ImportError(f"OpenSeesPy cannot be loaded: {cause}") from error


def cosine(beam: Beam, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The handout's shape at X of the span, 0 to 1: places along and across, um."""
    return beam.span * X, beam.rise * (1 - np.cos(2 * np.pi * X)) / 2


def arc(beam: Beam, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Part of a circle, at X of its length."""
    R = (beam.span**2 / 4 + beam.rise**2) / (2 * beam.rise)
    angle = np.arcsin(beam.span / 2 / R) * (2 * X - 1)
    return beam.span / 2 + R * np.sin(angle), R * np.cos(angle) - R + beam.rise


class Arch:
    """One beam in OpenSees, which holds one model at a time."""

    def __init__(self, beam: Beam, shape, elements: int, whole: bool = False, bent: float = 0.0):
        """Bent: imperfection over the rise, by which a path branches: in the second symmetric
        shape, or of a whole beam in an antisymmetric one."""
        self.ops, self.beam, self.share = load(), beam, 1 if whole else 2
        X = np.linspace(0, 1, elements + 1)[: None if whole else elements // 2 + 1]
        second = np.sin(2 * np.pi * X) ** 2
        x, y = shape(beam, X)
        y = y + bent * beam.rise * (second * np.sign(0.5 - X) if whole else second)
        self.end, self.middle = X.size, elements // 2 + 1
        self._lay(x, y)
        lengths = np.hypot(np.diff(x), np.diff(y))
        self.lengths = (np.append(lengths, 0) + np.append(0, lengths)) / 2

    def _lay(self, x, y):
        ops, beam = self.ops, self.beam
        ops.wipe()
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        for node, place in enumerate(zip(x.tolist(), y.tolist(), strict=True), start=1):
            ops.node(node, *place)
        ops.fix(1, 1, 1, 1)
        ops.fix(self.end, 1, int(self.share == 1), 1)
        ops.geomTransf("Corotational", TURN)
        section = float(beam.area), float(beam.youngs_modulus), float(beam.inertia)
        mass = "-mass", float(beam.mass_per_length), "-cMass"
        for node in range(1, self.end):
            ops.element("elasticBeamColumn", node, node, node + 1, *section, TURN, *mass)

    def path(self, way: float, uniform: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Displacement of the midpoint, up to `way`, and the force there, or the load per length.

        The load keeps its direction; a uniform one is per length of the beam as made.
        """
        ops = self.ops
        ops.timeSeries("Linear", SERIES)
        ops.pattern("Plain", PATTERN, SERIES)
        if uniform:
            self._press(self.lengths)
        else:
            ops.load(self.middle, 0.0, -1.0 / self.share, 0.0)
        self._solve("Static", ("DisplacementControl", self.middle, 2, -way / STEPS))
        found = np.zeros((STEPS + 1, 2))
        for step in range(1, STEPS + 1):
            if ops.analyze(1):
                raise ArithmeticError(f"OpenSees does not converge at {found[step - 1, 0]:g} um")
            found[step] = -ops.nodeDisp(self.middle, 2), ops.getTime()
        return found[:, 0], found[:, 1]

    def growing_force(self, rate: float, step: float) -> float:
        """The force, growing from 0 by rate, uN/us, when the midpoint has moved by the rise."""
        ops = self.ops
        ops.timeSeries("Linear", SERIES, "-factor", rate / self.share)
        ops.pattern("Plain", PATTERN, SERIES)
        ops.load(self.middle, 0.0, -1.0, 0.0)
        self._solve("Transient", ("TRBDF2",))
        while -ops.nodeDisp(self.middle, 2) < self.beam.rise:
            self._advance(step)
        return rate * ops.getTime()

    def motion(
        self, device: Device, shock: tuple[float, float, float], step: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Time and way of the half beam's midpoint, struck by the mass, to the snap or for 2/f0.

        shock: N, f0 in 1/us and C; that it snaps is seen at SNAPPED rises
        """
        ops, (N, f0, C), end = self.ops, shock, self.end
        mass, ground = end + 1, end + 2
        for node in (mass, ground):
            ops.node(node, *ops.nodeCoord(end))
            ops.fix(node, 1, int(node == ground), 1)
        ops.mass(mass, 0.0, device.mass / 2, 0.0)
        ops.uniaxialMaterial("Elastic", SPRING, device.spring / 2, C / 2)
        ops.uniaxialMaterial("ENT", CONTACT, device.contact / 2)
        ops.element("zeroLength", SPRING, ground, mass, "-mat", SPRING, "-dir", 2)
        ops.element("zeroLength", CONTACT, end, mass, "-mat", CONTACT, "-dir", 2)
        # As forces: UniformExcitation counts the mass of the elements twice.
        times = np.linspace(0, 1 / f0, 4001)
        a = N * device.gravity / 2 * (1 - np.cos(2 * np.pi * f0 * times))
        ops.timeSeries("Path", SERIES, "-dt", times[1], "-values", *a.tolist())
        ops.pattern("Plain", PATTERN, SERIES)
        self._press(self.beam.mass_per_length * self.lengths)
        ops.load(mass, 0.0, -device.mass / 2, 0.0)
        self._solve("Transient", ("TRBDF2",))
        found = [(0.0, 0.0)]
        while ops.getTime() < 2 / f0 and found[-1][1] < SNAPPED * self.beam.rise:
            self._advance(step)
            found.append((ops.getTime(), -ops.nodeDisp(end, 2)))
        return tuple(np.array(found).T)

    def _press(self, loads):
        for node, load in enumerate(loads.tolist(), start=1):
            self.ops.load(node, 0.0, -load, 0.0)

    def _solve(self, kind, integrator):
        ops = self.ops
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-10 * float(self.beam.rise), 50)
        ops.algorithm("Newton")
        ops.integrator(*integrator)
        ops.analysis(kind)

    def _advance(self, step):
        if self.ops.analyze(1, step) and self.ops.analyze(20, step / 20):
            raise ArithmeticError(f"OpenSees does not converge at {self.ops.getTime():g} us")
