"""Errors due to the time steps, by question, for docs/accuracy.md.

./run python -m studies steps [--small]
"""

import warnings
from dataclasses import replace

import numpy as np

from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import batch
from snapmap.pulse.pulse import make_pulse
from snapmap.pulse.shocks import Shocks
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import EDGE, SNAP, Run
from snapmap.solver.steps import LONGEST
from snapmap.thresholds.probe import Probe
from snapmap.thresholds.search import scan_upwards

from .common import command_device, few, number, threshold_near
from .random_devices import FREQUENCIES, draw_any_device, draw_device, draw_pulse, draw_shocks, even
from .tables import Table, write

SEED, DEVICES, DEVICES_SLOW, COSINES = 5, 8, 2, 7
DEFAULT = "default"
RULES = {
    DEFAULT: {},
    "for a label": {"question": SNAP},
    "all steps halved": {"factor": 0.5},
    "all steps doubled": {"factor": 2.0},
    "`PER_SWING` halved": {"per_swing": 0.5},
    "`SHORTEST` doubled": {"shortest": 2.0},
    "`BLOWS` halved": {"blows": 0.5},
    "`LONGEST` doubled": {"longest": 2.0},
    "`LONGEST` twenty times": {"longest": 20.0},
    "`MOST` halved": {"most": 0.5},
}
"""Factors on the constants of the rule for EDGE, by the name of each rule."""
SLOW_RULES = {key: RULES[key] for key in (DEFAULT, "`MOST` halved")}
FINE, FINER = {"factor": 0.15}, {"factor": 0.1}
AGREED, REFINED, NEAR = 2e-4, 2e-6, 1.04
"""Largest difference of the fine rules in a well-posed row; tolerance of thresholds; factor within
which they are searched."""
F0, C = np.geomspace(1e3, 3e4, 18), np.array([25.0, 200.0])
"""Shocks of the handout's device under which the mass strikes the beam again and again."""
PRESSED = 0.003, 1.0
"""Range of f0 over the device's own at which a mass presses on a hard contact without a gap."""
SLOW = 0.004, 0.1
"""Range of f0 over the device's own at which a pulse moves the mass from rest to rest."""
LANDINGS = {
    "at rest": lambda device, draw: device,
    "at rest, hard": lambda device, draw: replace(device, contact=np.inf),
    "gap": lambda device, draw: replace(device, gap=device.beam.rise * even(draw, 0.03, 3.0)),
    "gap, hard": lambda device, draw: LANDINGS["gap"](replace(device, contact=np.inf), draw),
    "stop": lambda device, draw: replace(device, stop_away=device.beam.rise * even(draw, 0.1, 3.0)),
}
"""Devices by what their mass meets under a slow pulse."""
LONGEST_PULSE = 1e5
"""Pulses that last longer, in radians of the arch, are left out if nothing presses on the beam."""


def main():
    warnings.simplefilter("ignore")
    of_devices = [f"{of}: {key}" for of in ("random devices", "handout's") for key in HEAD]
    write(
        "steps",
        Table("steps", ["steps", *of_devices[:-1]], [*edges()]),
        Table("steps_pressed", ["steps, pressed on a hard contact", *HEAD], [*pressed()]),
        Table("steps_slow", ["slow pulses", "steps", *HEAD], [*slow()]),
    )


HEAD = ["rows", "median, %", "90 %, %", "largest, %", "no threshold near"]


def changed(model, question=EDGE, factor=1.0, longest=1.0, **factors):
    """Return the model with factors on constants of its rule for EDGE, and the question to ask."""
    steps = model.steps.times(factor)
    parts = {key: times * getattr(steps, key) for key, times in factors.items()}
    parts["longest"] = {**steps.longest, EDGE: longest * steps.longest[EDGE]}
    return replace(model, steps=replace(steps, **parts)), question


def edges():
    """Yield rows of errors of thresholds by rule, of random devices and of the handout's."""
    draw, count = np.random.default_rng(SEED), range(few(DEVICES))
    errors = [errors_of(draw_any_device(draw), draw_pulse(draw), draw) for _ in count]
    device = command_device()
    rows = to_rows(0, few(F0), C[:, np.newaxis])
    of_handout = errors_of_rows(device, rows, Run())
    of_random = np.concatenate(errors, axis=1)
    for name, random, handout in zip(few(RULES), of_random, of_handout, strict=True):
        yield [name, *_spread(random), *_spread(handout)[:-1]]


def pressed():
    """Yield rows of errors of thresholds by rule, of devices with a hard contact and no gap."""
    draw, errors = np.random.default_rng(SEED + 1), []
    for _ in range(few(DEVICES)):
        device = replace(draw_device(draw), contact=np.inf)
        errors.append(errors_of(device, draw_pulse(draw), draw, PRESSED, np.inf))
    for name, of_rule in zip(few(RULES), np.concatenate(errors, axis=1), strict=True):
        yield [name, *_spread(of_rule)]


def slow():
    """Yield rows of errors of thresholds of slow pulses, by what the mass meets, and by rule."""
    shocks = Shocks(make_pulse())
    for name, landing in few(LANDINGS).items():
        draw, errors = np.random.default_rng(SEED + 2), []
        for _ in range(few(DEVICES_SLOW)):
            device = landing(draw_device(draw), draw)
            errors.append(errors_of(device, shocks, draw, SLOW, np.inf, SLOW_RULES))
        for rule, of_rule in zip(few(SLOW_RULES), np.concatenate(errors, axis=1), strict=True):
            yield [name, rule, *_spread(of_rule)]


def _spread(errors):
    """Number of rows, quantiles of their errors, and number of rows without a threshold near."""
    off = abs(errors[np.isfinite(errors)])
    spread = np.quantile(off, [0.5, 0.9, 1.0]) if off.size else np.full(3, np.nan)
    shown = [number(100 * value) for value in spread]
    return [str(errors.size), *shown, str(np.sum(np.isnan(errors)))]


def errors_of(device, shocks, draw, frequencies=FREQUENCIES, longest=LONGEST_PULSE, rules=RULES):
    """Find relative errors of the well-posed thresholds of a random device, (rules, rows)."""
    model = build_model(batch([device]), Cosines(modes=COSINES))
    f0, C = draw_shocks(draw, device, frequencies)
    arch = LONGEST[SNAP] / model.steps.longest[SNAP].item()
    f0 = [f for f in f0 if 2e-6 * np.pi * f * longest > arch] or f0[-1:]
    rows = to_rows(0, np.array(f0), np.array(C)[:, np.newaxis], 0, shocks.pulses)
    horizon = min(4 * 2 * np.pi / device.own_frequency, 3e4 / arch)
    return errors_of_rows(device, rows, Run(horizon=horizon), rules)


def errors_of_rows(device, rows, settings, rules=RULES):
    """Find relative errors of well-posed thresholds, (rules, rows); NaN if none is near."""
    model = build_model(batch([device]), Cosines(modes=COSINES))

    def ask(rule):
        ruled, question = changed(model, **rule)
        return Probe(ruled, rows, settings, question)

    def near(rule, N):
        return threshold_near(ask(rule), N, NEAR, REFINED)

    bound = least_amplitudes(model, rows)
    static = static_threshold(model.device)
    fine = near(FINE, scan_upwards(ask(RULES[DEFAULT]), static, bound)[0])
    finer = near(FINER, fine)
    posed = abs(fine / finer - 1) < AGREED
    known = np.where(posed, finer, np.nan)
    return np.array([near(rule, known) / known - 1 for rule in few(rules).values()])[:, posed]
