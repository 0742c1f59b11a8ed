"""Half of a guided beam as corotational elements of OpenSeesPy: exact geometry, without shear.

Units are those of the package: um, ng, us, uN.
"""

import ctypes
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from snapmap.device.device import Beam, Device

STEPS = 1600
"""Number of steps of the midpoint along a path."""
SNAPPED = 1.6
"""Displacement of the midpoint, in rises, from which no pressed beam comes back."""
SERIES, PATTERN, TURN, SPRING, CONTACT = 1, 1, 1, 1001, 1002
"""Tags, which OpenSees wants."""


def load():
    """Import OpenSees; ImportError, in one line, where it is not installed or does not load."""
    wheel = find_spec("openseespylinux")
    if not wheel:
        raise ImportError("openseespylinux is not installed")
    try:
        # The wheel brings a libblas that its own libraries do not find.
        ctypes.CDLL(str(Path(wheel.origin).parent / "lib" / "libblas.so.3"))
        return import_module("openseespylinux.opensees")
    except OSError as error:
        raise ImportError(f"openseespylinux does not load: {error}") from error


class HalfBeam:
    """Half of a beam, clamped at its first node and guided at its last; OpenSees holds one."""

    def __init__(self, beam: Beam, elements: int, bent: float = 0.0):
        """Lay the cosine in half of so many elements.

        bent: imperfection over the rise in the second symmetric shape, by which a path branches
        """
        self.ops, self.beam = load(), beam
        X = np.linspace(0, 0.5, elements // 2 + 1)
        y = (1 - np.cos(2 * np.pi * X)) / 2 + bent * np.sin(2 * np.pi * X) ** 2
        self._lay(beam.span * X, beam.rise * y)
        lengths = np.hypot(np.diff(beam.span * X), np.diff(beam.rise * y))
        self.lengths = (np.append(lengths, 0) + np.append(0, lengths)) / 2

    def _lay(self, x, y):
        ops, beam, self.end = self.ops, self.beam, x.size
        ops.wipe()
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        for node, place in enumerate(zip(x.tolist(), y.tolist(), strict=True), start=1):
            ops.node(node, *place)
        ops.fix(1, 1, 1, 1)
        ops.fix(self.end, 1, 0, 1)
        ops.geomTransf("Corotational", TURN)
        section = float(beam.area), float(beam.youngs_modulus), float(beam.inertia)
        mass = "-mass", float(beam.mass_per_length), "-cMass"
        for node in range(1, self.end):
            ops.element("elasticBeamColumn", node, node, node + 1, *section, TURN, *mass)

    def path(self, rises: float) -> tuple[np.ndarray, np.ndarray]:
        """Return displacements of the midpoint, um, up to so many rises, and the forces on it."""
        ops, step = self.ops, rises * self.beam.rise / STEPS
        ops.timeSeries("Linear", SERIES)
        ops.pattern("Plain", PATTERN, SERIES)
        ops.load(self.end, 0.0, -0.5, 0.0)
        self._solve("Static", "DisplacementControl", self.end, 2, -step)
        forces = np.zeros(STEPS + 1)
        for i in range(1, STEPS + 1):
            if ops.analyze(1):
                raise ArithmeticError(f"OpenSees does not converge at {i * step:g} um")
            forces[i] = ops.getTime()
        return step * np.arange(STEPS + 1), forces

    def motion(
        self, device: Device, shock: tuple[float, float, float], step: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return times, us, and displacements of the midpoint under the mass, to SNAPPED or 2/f0.

        shock: N, f0 in 1/us and C
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
        for node, load in enumerate((self.beam.mass_per_length * self.lengths).tolist(), start=1):
            ops.load(node, 0.0, -load, 0.0)
        ops.load(mass, 0.0, -device.mass / 2, 0.0)
        self._solve("Transient", "TRBDF2")
        found = [(0.0, 0.0)]
        while ops.getTime() < 2 / f0 and found[-1][1] < SNAPPED * self.beam.rise:
            if ops.analyze(1, step) and ops.analyze(20, step / 20):
                raise ArithmeticError(f"OpenSees does not converge at {ops.getTime():g} us")
            found.append((ops.getTime(), -ops.nodeDisp(end, 2)))
        return tuple(np.array(found).T)

    def _solve(self, kind, *integrator):
        ops = self.ops
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-10 * float(self.beam.rise), 50)
        ops.algorithm("Newton")
        ops.integrator(*integrator)
        ops.analysis(kind)
