"""How far the laws of slow and of short shocks hold, for docs/applications/laws.md.

./run python -m studies laws [--small]
"""

import math

import numpy as np

from snapmap import Study, threshold
from snapmap.applications.laws.laws import laws_of
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import Beam, Device, batch
from snapmap.files.text import plain
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import HANDOUT_PULSES, Rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe
from snapmap.thresholds.slow import (
    PART,
    departure_rate,
    fall,
    falling_stiffness,
    obstacles,
    slow_factor,
)

from . import random_devices
from .common import command_device, few
from .random_devices import even
from .tables import Table, write

SEED, DEVICES = 55, 400
OF_LIMIT, OUTSIDE = (1.0, 0.5, 0.25), 0.3
"""Steepness of shocks over the steepest slow ones, and pi f0 / sigma of devices without a law."""
HIGHEST, ROUNDS, PARTS = 8.0, 4, 8
"""Largest excess over the law's that is searched, in ROUNDS, each with PARTS parts."""
MODEL, DAMPING = Cosines(modes=11), (0.01, 30.0)
"""The model, and the range of C over critical damping of the departure, 2 sqrt(M kappa)."""
FAST, OF_SHORT, DAMPED = (2.0, 5.0, 10.0, 20.0), 15, 0.1
"""f0 over the higher one of the frequencies of mass and beam; devices; their C over sqrt(K M)."""
F0, C = np.geomspace(50.0, 2e5, 145), (0.025, 25.0)
SLOW_WITHIN, SHORT_WITHIN = 0.01, 0.07
LIMITS = ["C, µN µs/µm", "$2/\\sigma$, µs", "`N_slow` within 1 % up to, Hz", "velocity change, m/s"]
LIMITS += ["within 7 % from, Hz"]
HEAD = ["devices", "$\\pi f_0/\\sigma$", "number", "`N_slow` off by, %: median", "5 to 95 %"]
HEAD += ["extremes", "time over `dwell`: median", "5 to 95 %", "extremes"]
SHORT = ["f0 over the frequency of mass or beam", "thresholds", "velocity change off by, %: median"]
SHORT += ["5 to 95 %", "extremes", "delays", "over a saddle's: median", "5 to 95 %", "extremes"]


def main():
    draw = np.random.default_rng(SEED)
    devices = batch([draw_device(draw) for _ in range(few(DEVICES, 4))])
    rate_1, static = departure_rate(devices, 1.0), static_threshold(devices)
    kappa = (1 + devices.mass * rate_1) * rate_1
    C = 2 * np.sqrt(devices.mass * kappa) * np.exp(draw.uniform(*np.log(DAMPING), len(devices)))
    reasons = obstacles(devices, static)
    rows, within = [], ~np.logical_or.reduce([*reasons.values()])
    for share in few(OF_LIMIT):
        steep = share * np.sqrt(PART * fall(devices, static)[within])
        rows.append(_row("with a law", devices.pick(within), C[within], static[within], steep))
    for reason, is_so in few(reasons).items():
        alone = is_so & (np.sum([*reasons.values()], axis=0) == 1)
        if alone.any():
            steep = np.full(alone.sum(), OUTSIDE)
            rows.append(_row(reason, devices.pick(alone), C[alone], static[alone], steep))
    short = Table("laws_short", SHORT, [*shorts(draw)])
    write("laws", Table("laws", HEAD, rows), Table("laws_handout", LIMITS, [*limits()]), short)


def shorts(draw):
    """Yield how far the laws of short pulses and of delays are off, a row for each frequency."""
    off, late = [], []
    for _ in range(few(OF_SHORT, 2)):
        device = random_devices.draw_device(draw)
        fastest = 1e6 / (2 * math.pi) * max(device.mass_frequency, device.beam.bending_frequency)
        C = DAMPED * math.sqrt(device.spring * device.mass)
        study, axes = Study(device), {"C": [C], "f0": [ratio * fastest for ratio in FAST]}
        found = laws_of(study, study.set_out(axes), threshold(study, axes["f0"], axes["C"]))
        found = found.squeeze("C")
        off.append(100 * (found.N_short / found.N_first - 1).values)
        ratio = found.snap_scale / found.saddle_scale
        late.append(ratio.isel(saddle=abs(np.log(ratio)).fillna(0).argmin("saddle")).values)
    for place, ratio in enumerate(FAST):
        cells = []
        for values, digits in ((np.array(off)[:, place], 1), (np.array(late)[:, place], 2)):
            known = values[np.isfinite(values)]
            cells += [f"{known.size} of {values.size}", *_spread(known, digits)]
        yield [f"{ratio:g}", *cells]


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
    """Draw a device whose spring is softer than the falling beam, and whose contact is stiffer."""
    t, Q = even(draw, 0.5, 5.0), draw.uniform(2.6, 10.0)
    beam = Beam(300 * t, Q * t, t, depth=20.0, youngs_modulus=1.5e5, density=2.33e-3)
    falls, mass = falling_stiffness(beam), beam.weight * even(draw, 30.0, 3000.0)
    contact = math.inf if draw.random() < 0.5 else falls * even(draw, 1.2, 1000.0)
    spring = (1 - even(draw, 0.02, 0.98)) / (1 / falls - 1 / contact)
    return Device(beam, mass=mass, spring=spring, contact=contact, gravity=9.81e-6)


def _row(name, devices, C, static, steep):
    """Compare the law with thresholds of versed sines; steep: pi f0 / sigma; all (devices,)."""
    every, rate = np.arange(len(devices)), departure_rate(devices, C)
    f0 = steep * rate / math.pi
    law = slow_factor(make_pulse(), rate / f0) - 1
    rows = Rows(every, 1e6 * f0, C, 0 * every, HANDOUT_PULSES)
    probe = Probe(build_model(devices, MODEL), rows, Run())
    low, width = np.zeros(law.size), HIGHEST
    for _ in range(ROUNDS):
        width = width / PARTS
        shares = low[:, np.newaxis] + width * np.arange(1, PARTS)
        snaps = np.isfinite(probe(static[:, np.newaxis] * (1 + shares * law[:, np.newaxis])))
        low = low + width * np.where(snaps.any(axis=1), snaps.argmax(axis=1), PARTS - 1)
    over = (low + width / 2) * law
    above = (1 - np.arccos(1 - 2 / (1 + over)) / math.pi) / f0
    off, ends = 100 * ((1 + law) / (1 + over) - 1), (steep.min(), steep.max())
    span = " to ".join(dict.fromkeys(f"{end:.2g}" for end in ends))
    return [name, span, str(law.size), *_spread(off, 2), *_spread(above * rate / 2, 2)]


def _spread(values, digits):
    """Write the median of values, where nine in ten are, and their extremes; nothing of none."""
    if not values.size:
        return [""] * 3
    ends = [f"{value:.{digits}f}" for value in np.percentile(values, [50, 5, 95, 0, 100])]
    return [ends[0], f"{ends[1]} to {ends[2]}", f"{ends[3]} to {ends[4]}"]
