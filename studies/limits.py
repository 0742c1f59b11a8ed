"""How values of the device, and what the model leaves out, move thresholds, for docs/limits.md.

./run python -m studies limits [--small]
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from snapmap import Study, simulate, threshold
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import Device
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .clamps import ANCHORS, ELEMENTS, compliance, thresholds, turning_elements
from .common import command_device, few, with_beam
from .tables import Table, write

F0, C, TOLERANCE = [500.0, 1500.0, 5000.0], 25.0, 1e-6
SETTINGS = Run(horizon=1500.0)
PERCENT = 1.01
OF_BEAM = "span", "rise", "thickness", "depth", "youngs_modulus", "density"
OF_DEVICE = "mass", "spring", "contact", "gravity"
BEAMS = {
    "eigenstrain 1e-4 (-15 MPa)": {"residual_stress": -15.0},
    "eigenstrain -1e-4 (15 MPa)": {"residual_stress": 15.0},
    "damping of the beam 4e-4 /us": {"damping": 4e-4},
    "damping of the beam 4e-3 /us": {"damping": 4e-3},
}
GAPS = 0.5, 1.0, 2.0
DAMPINGS = {"C = 0.025 uN us/um": 0.025, "C = 200 uN us/um": 200.0}
WAITS = 10.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0
"""Times between two equal shocks, us."""
STOPS = {
    "none": {},
    "15 and 6 um, 0.9": {"stop_toward": 15.0, "stop_away": 6.0, "restitution": 0.9},
    "10 and 6 um, 0.5": {"stop_toward": 10.0, "stop_away": 6.0, "restitution": 0.5},
}
STOPPED, TILTED = [1500.0, 5000.0, 30000.0], [200.0, 1590.0, 3170.0, 20000.0]
BENDS = {
    "guided": {},
    "free, imperfection 0.01 um": {"free": 1.0, "imperfection": 0.01},
    "free, 0.5 um": {"free": 1.0, "imperfection": 0.5},
}
LOADS, MODES, UNDAMPED = (984.0, 2400.0), (5, 11, 21), 0.025


def main():
    device = command_device()
    changes = measured_changes(device)
    tables = left_out(device, changes), of_changes(device, changes), stops(device), tilt(device)
    write("limits", *tables, stress(device))


def variants(device: Device) -> dict[str, tuple[Device, float]]:
    """Return changed devices, and C, by what is changed."""
    beams = {f"1 % more {key}": {key: PERCENT * getattr(device.beam, key)} for key in OF_BEAM}
    made = {name: with_beam(device, **values) for name, values in (beams | BEAMS).items()}
    for key in OF_DEVICE:
        made[f"1 % more {key}"] = replace(device, **{key: PERCENT * getattr(device, key)})
    made |= {f"gap {gap:g} um": replace(device, gap=gap) for gap in GAPS}
    damped = {name: (device, damping) for name, damping in DAMPINGS.items()}
    return {name: (other, C) for name, other in made.items()} | damped


def measured_changes(device: Device) -> dict[str, np.ndarray]:
    """Measure how changes of the device move the static threshold and those at F0, in per cent."""
    before, cases = levels(device, C), few(variants(device), 3)
    return {name: 100 * (levels(*case) / before - 1) for name, case in cases.items()}


def levels(device: Device, damping: float) -> np.ndarray:
    """Find the static threshold and those at F0, (1 + F0,)."""
    model = build_model(device, Cosines(modes=few(5, 3)))
    probe = Probe(model, to_rows(0, few(F0, 2), damping), SETTINGS)
    return np.array([static_threshold(device), *lowest_snap(probe, (300.0, 3000.0), TOLERANCE)])


def of_changes(device: Device, changes: Mapping[str, np.ndarray]) -> Table:
    """Make a table of changes of thresholds."""
    rows = [["none: the threshold, in g", *(f"{N:.1f}" for N in levels(device, C))]]
    rows += [[name, *(f"{percent:+.2f}" for percent in row)] for name, row in changes.items()]
    head = ["change", "static, %", *(f"{f0:g} Hz, %" for f0 in F0)]
    return Table("limits_changes", head, rows)


def left_out(device: Device, changes: Mapping[str, np.ndarray]) -> Table:
    """Make a table of causes that the model leaves out, and their effects on the threshold."""

    def measured(*names):
        ends = sorted(changes[name][2] for name in names if name in changes)
        return " to ".join(f"{end:+.1f}" for end in ends), "measured"

    beam, span = device.beam, device.beam.span
    loss = 100 * beam.weight / (device.mass + beam.weight)
    slope, shear = math.pi * beam.rise / span, 2 * math.pi * beam.thickness / span
    package = 100 / largest_response() - 100
    rows = [
        ["1 % more thickness than thought", *measured("1 % more thickness"), "calibrate"],
        ["anchors that turn", f"{turned(device):+.1f}", "measured", "see the table of anchors"],
        ["gas: C = 0.025 to 200", *measured(*DAMPINGS), "sweep C"],
        ["an inelastic impact", f"to {loss / 2:+.1f}", "half of m/(M + m)", "sweep `damping`"],
        ["an equal shock before", f"{after_another(device):+.1f}", "measured", "simulate a train"],
        ["resonance of the package", f"to {package:+.0f}", "an oscillator", "measure at the die"],
        ["slope of the beam", f"some {100 * slope**2:.1f}", "(pi rise/span)^2", "mind rise/span"],
        ["shear in the beam", f"some {100 * shear**2:.2f}", "(2 pi thickness/span)^2", "none"],
        ["rotation of the mass, other directions", "not known", "", "none here"],
    ]
    return Table("limits", ["cause", "threshold, %", "by", "what to do"], rows)


def largest_response() -> float:
    """Find the largest response of an undamped oscillator to a versed sine, over the slow one.

    It comes during the pulse, of an oscillator about as fast.
    """
    own, x = np.linspace(0.8, 1.2, 400)[:, np.newaxis], 2 * np.pi * np.linspace(0.0, 1.0, 2000)
    forced = own**2 / (own**2 - 1) * (np.cos(x) - np.cos(own * x))
    return np.max(1 - np.cos(own * x) - forced) / 2


def turned(device: Device) -> float:
    """Find what an anchor of linear stress changes at 1500 Hz, in per cent."""
    ends = compliance(device.beam, ANCHORS["linear stress"]), 0.0
    bases = (turning_elements(ELEMENTS, b) for b in ends)
    soft, rigid = (thresholds(device, basis, F0[1:2])[0] for basis in bases)
    return 100 * (soft / rigid - 1)


def after_another(device: Device) -> float:
    """Find what an equal shock of 1500 Hz before changes, at the worst of WAITS, in per cent."""
    blow, found = {"shape": "versed sine", "N": 1.0, "duration": 1e6 / F0[1]}, []
    for wait in few(WAITS, 2):
        study = Study(device, pulse={"train": [blow, {"wait": wait}, {"repeat": 2}]})
        f0 = 1e6 / study.shocks.pulse.duration
        found.append(threshold(study, f0, C).N_first.item())
    return 100 * (min(found) / threshold(device, F0[1], C).N_first.item() - 1)


def stops(device: Device) -> Table:
    """Make a table of thresholds between stops, in both directions."""
    rows = []
    for name, values in few(STOPS, 2).items():
        of_way = (Study(replace(device, **values), direction=way) for way in ("+z", "-z"))
        rows.append([name, *(cell for study in of_way for cell in with_bars(study, few(STOPPED)))])
    head = [f"{way} {f0:g} Hz" for way in ("+z", "-z") for f0 in STOPPED]
    return Table("limits_stops", ["stops, restitution", *head], rows)


def tilt(device: Device) -> Table:
    """Make a table of thresholds of guided beams and of those free to tilt."""
    rows = []
    for name, values in few(BENDS, 2).items():
        other = with_beam(device, **values)
        cells = with_bars(Study(other), few(TILTED))
        rows.append([name, f"{static_threshold(other):.0f}", *cells])
    head = ["beam", "static", *(f"{f0:g} Hz" for f0 in TILTED)]
    return Table("limits_tilt", head, rows)


def with_bars(study: Study, f0: list[float]) -> list[str]:
    """Write thresholds with their bars."""
    found = threshold(study, f0, C).squeeze("C")
    pairs = zip(found.N_first.values, found.N_error.values, strict=True)
    return [f"{N:.{bar < 2:d}f} ± {bar:.{bar < 2:d}f}" if N == N else "none" for N, bar in pairs]


def stress(device: Device) -> Table:
    """Make a table of the largest stress up to the snap, and in the whole history, MPa."""
    rows = []
    for N in few(LOADS):
        for modes in few(MODES):
            study = Study(device, Cosines(modes=modes), **vars(SETTINGS))
            seen = simulate(study, N, F0[1], UNDAMPED)
            both = seen.stress_max_to_snap.item(), seen.stress_max.item()
            rows.append([f"{N:g}", str(modes), *(f"{value:.1f}" for value in both)])
    return Table("limits_stress", ["N", "cosines", "up to the snap, MPa", "in all, MPa"], rows)
