"""How far the laws of slow and of short shocks hold, for docs/applications/laws.md.

./run python -m studies laws [--small]
"""

import math

import numpy as np

from snapmap import threshold
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import Beam, Device, batch
from snapmap.files.text import plain
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import HANDOUT_PULSES, Rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap
from snapmap.thresholds.slow import growth_rate, slow_factor

from .common import command_device, few, number
from .random_devices import even
from .tables import Table, write

SEED, DEVICES = 55, 100
RATIOS = {0.02: 2e-3, 0.05: 1e-2, 0.1: 3e-2}
"""Values of pi f0 / sigma, each with the relative distance from the law to search thresholds."""
PARTS, TOLERANCE, WITHIN = 8, 2e-6, (1e-4, 1e-3, 1e-2)
MODEL, STEP = Cosines(modes=11), 0.5
"""The model, and its steps over the default ones."""
DAMPING = 0.02
"""C over sqrt(K M)."""
F0, C = np.geomspace(50.0, 2e5, 145), (0.025, 25.0)
SLOW_WITHIN, SHORT_WITHIN = 0.01, 0.07
LIMITS = ["C, µN µs/µm", "$2/\\sigma$, µs", "`N_slow` within 1 % up to, Hz", "velocity change, m/s"]
LIMITS += ["within 7 % from, Hz"]
HEAD = ["$\\pi f_0/\\sigma$", "thresholds", "excess over the law's, median", "error of N: median"]
HEAD += ["90 %", "largest", *(f"within {share:g}, %" for share in WITHIN)]


def main():
    draw = np.random.default_rng(SEED)
    devices = batch([draw_device(draw) for _ in range(few(DEVICES, 2))])
    of_random = [_row(devices, *ratio) for ratio in few(RATIOS).items()]
    write("laws", Table("laws", HEAD, of_random), Table("laws_handout", LIMITS, [*limits()]))


def limits():
    """Yield how far both laws hold for the handout's device, a row for each C."""
    device = command_device()
    for damping in few(C):
        edges = threshold(device, few(F0, 40), [damping]).squeeze("C")
        short = 1e-6 * edges.f0 * edges.velocity_change / (edges.area * device.gravity)
        slow = _reach(edges.N_slow / edges.N_first, SLOW_WITHIN)
        fast = _reach((short / edges.N_first)[::-1], SHORT_WITHIN)
        values = edges.dwell.item(), slow, edges.velocity_change.item(), fast
        yield [f"{damping:g}", *(plain(value) for value in values)]


def _reach(ratio, within):
    """Return the last f0, Hz, up to which a ratio is within a share of 1."""
    holds = np.cumprod(abs(ratio.values - 1) <= within).astype(bool)
    return ratio.f0.values[holds][-1] if holds.any() else np.nan


def draw_device(draw: np.random.Generator) -> Device:
    """Draw a device within the assumptions of the law."""
    t, Q = even(draw, 0.5, 5.0), draw.uniform(3.0, 8.0)
    beam = Beam(300 * t, Q * t, t, depth=20.0, youngs_modulus=1.5e5, density=2.33e-3)
    falls = 64 * math.pi**2 * beam.stiffness_unit
    mass, spring = beam.weight * even(draw, 30.0, 3000.0), falls * draw.uniform(0.1, 0.8)
    contact = falls * even(draw, 5.0, 1000.0)
    return Device(beam, mass=mass, spring=spring, contact=contact, gravity=9.81e-6)


def _row(devices, ratio, reach):
    every = np.arange(len(devices))
    C = DAMPING * np.sqrt(devices.spring * devices.mass)
    rate, static = growth_rate(devices, C), static_threshold(devices)
    f0 = ratio * rate / math.pi
    law = static * slow_factor(make_pulse(), rate / f0)
    rows = Rows(every, 1e6 * f0, C, 0 * every, HANDOUT_PULSES)
    model = build_model(devices, MODEL).with_step(STEP)
    bracket = law * (1 - reach), law * (1 + reach)
    N = lowest_snap(Probe(model, rows, Run()), bracket, TOLERANCE, reach / PARTS)
    excess, error = (N / static - 1) / (law / static - 1), abs(N / law - 1)
    shares = (f"{100 * np.mean(error <= share):.0f}" for share in WITHIN)
    known = np.isfinite(N)
    middle = number(np.median(excess[known]))
    off = (f"{value:.1e}" for value in np.percentile(error[known], [50, 90, 100]))
    return [f"{ratio:g}", f"{known.sum()} of {N.size}", middle, *off, *shares]
