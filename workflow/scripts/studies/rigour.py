"""Prints docs/rigour.md: barrier, rounding and one threshold, enclosed by ball arithmetic.

PYTHONPATH=workflow/scripts ./run python -m studies.rigour [--small] > docs/rigour.md
"""

import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from snapmap import load_device, threshold
from snapmap.io.markdown import table
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.lanes import ROUNDING
from snapmap.solver.models import build_model
from snapmap.solver.settings import STAY, Settings

from .few import few, is_small
from .random_devices import draw_any_device

ROOT = Path(__file__).resolve().parents[3]
MODELS = {
    "3 cosines": ("cosines", {"modes": 3}),
    "7 cosines": ("cosines", {"modes": 7}),
    "5 elements": ("handout", {}),
}
DEVICES, SEED = 24, 5
SETTINGS, C = Settings(1500.0), 25.0
N, F0 = (900.0, 1200.0, 1800.0), (500.0, 1500.0, 5000.0)
STEPS = 100_000
"""Most that rounding is followed through."""
CASE = {"f0": 10_000.0, "C": 200.0}
AMPLITUDES = 1578.560, 1578.561
SMALL = 3.0
"""us that a small run follows."""
TEXT = """\
# Beyond doubt

What is proven with balls in place of numbers (python-flint, of the group `bench`: each result
holds the exact one, rounding included), by one command, which prints this page:

    PYTHONPATH=workflow/scripts ./run python -m studies.rigour > docs/rigour.md

All of it is about the model as stored, its floats taken for exact numbers, and of its geometric
matrix, which is symmetric but for rounding, the symmetric part.

## The barrier

Equilibria are roots of one equation in the axial force ([theory](theory.md#tilt)); bisection with
balls misses none up to the barrier. The same among all shapes with the saddle's midpoint: none has
less energy, so that no motion with less passes it, and w(L/2) tells the well. Of {devices} devices,
the handout's and random ones (some stressed, some free to tilt), those that have a second shape;
shares of the barrier:

{barriers}

## The rounding of energies

The kernel's own lines, in floats and in balls from the same state, every 128 steps of runs up to
their proof or horizon: the handout's device, N 900 to 1800, f0 500 to 5000 Hz, C = {C:g}.
`Rounding` is the largest difference of the energies, and `a step` the largest change of the exact
energy in a step of floats that neither damping nor the pulse explains, over the barrier. `Proven`
are the runs whose whole energy is told to be below it; of them are counted those whose exact
energy is below the enclosed one, and those whose energy in the differential equation is, at the
same place and velocity.

{rounding}

A proof keeps {margin:g} of the barrier free for this, and twice the largest residual of the ledger;
until this study it was the residual alone, which may be 0 by chance.

## A threshold between two proofs

The handout's device, 3 cosines, f0 = {f0:g} Hz, C = {drag:g}, from rest: the solution of the
differential equation, with its kinks where contact begins and ends, is enclosed about Taylor
polynomials of {order} terms (steps of {step:g} us, {bits} bits). A snap is proven by an enclosure
beyond the target; that there is none, by enclosures short of it up to a time at which the pulse is
over and the energy below the barrier. `Digits lost`: by how much an error at the start would have
grown.

{runs}

{summary}

## What is a theorem, and what remains

- *The differential equation*: from the place and velocity of a run at its proof, counted in the
  last column above, it never leaves its well without a shock, whatever its damping. Its energy
  cannot rise, and no shape with the saddle's midpoint has as little.
- *The discrete run*: from its proof on, in exact arithmetic, $H$ never rises,
  and every later mean position has $W\\le H<E_s$
  ([theory](theory.md#a-scheme-that-keeps-its-energy)): it is in one of the two wells, and no later
  state is at the saddle's midpoint. Rounding adds `a step` at most for each.
- *What remains of it*: that a run does not leap over the saddle within one step is watched
  ([stability](stability.md)), not proven. A proof by parts (the beam below the barrier, the
  mass out of its reach) rests on the same energies, with the kernel's margin, and is not enclosed
  here.
- *The way to the proof*: the scheme's own error against the differential equation. Near an edge of
  the map a cell may be `never` truly of the run and wrongly of the equation. Steps, modes and
  meshes are compared in [accuracy](accuracy.md); enclosed is one cell on either side of one
  threshold, above.
- *The model* against a device: [limits](limits.md), [validation](validation.md).
"""


def main():
    if not find_spec("flint"):
        sys.exit("python-flint: missing; see the group `bench` in pyproject.toml")
    from flint import ctx

    from .enclosures import motion

    ctx.prec = motion.BITS
    device = load_device(ROOT / "config" / "config.yaml")
    runs, summary = bracket(device)
    words = {"order": motion.ORDER, "step": motion.STEP, "bits": motion.BITS}
    words |= {"devices": few(DEVICES, 2), "C": C, "margin": ROUNDING, "runs": runs}
    words |= {"f0": CASE["f0"], "drag": CASE["C"], "summary": summary}
    print(TEXT.format(barriers=barriers(device), rounding=rounding(device), **words), end="")


def barriers(device):
    """The stored barriers of devices, against what is enclosed."""
    from .enclosures import passes

    draw = np.random.default_rng(SEED)
    devices = [device, *(draw_any_device(draw) for _ in range(few(DEVICES, 2) - 1))]
    rows = []
    for label, (name, options) in few(MODELS).items():
        found = []
        for one in devices:
            soft = replace(one, contact=device.contact)
            model = build_model(soft, name, **options)
            if model.barrier.energy > 0:
                first, plane = passes.lowest(model.modal, model.barrier)
                ends = first.lower(), first.upper(), plane
                found.append([float(model.barrier.energy / end - 1) for end in ends])
        apart = np.array(found).T
        shown = max(apart[0]), -min(apart[1]), max(apart[2])
        rows.append([label, str(len(found)), *(f"{value:.1e}" for value in shown)])
    head = ["model", "devices", "stored too high, at most", "too low", "over all of that midpoint"]
    return table(head, rows)


def rounding(device):
    """The kernel's energies, against what is enclosed."""
    rows = []
    for contact in few((device.contact, np.inf)):
        for label, (name, options) in few(MODELS).items():
            model = build_model(replace(device, contact=contact), name, **options)
            found = [_cell(model, amplitude, f0) for amplitude in few(N) for f0 in few(F0)]
            looks, worst, drift, *proofs = zip(*found, strict=True)
            counts = [str(sum(value)) for value in proofs]
            errors = [f"{max(worst):.1e}", f"{max(drift):.1e}"]
            rows.append([label, f"{contact:g}", str(sum(looks)), *errors, *counts])
    head = ["model", "contact, N/m", "looks", "rounding", "a step", "proven", "by balls"]
    return table([*head, "of the equation"], rows)


def _cell(model, amplitude, f0):
    """How many looks, the largest rounding and drift; whether proven, by floats and by balls."""
    from .enclosures.rounding import looks

    cells = to_cells(model.device, 0, np.array([amplitude]), np.array([f0]), C, SETTINGS.horizon)
    dt = model.steps.of(cells, STAY).item()
    settled = model.follow_once(cells, SETTINGS).t_settled.item()
    end = settled if np.isfinite(settled) else cells.t_end.item()
    cell = cells.amplitude.item(), cells.f0.item(), C, dt
    seen, floor = looks(model, cells.pulses[0], cell, min(STEPS, round(end / dt) + 1))
    last, worst = seen[-1], max(float(abs(one.told - one.energy).upper()) for one in seen)
    drift = max(float(abs(one.drift).upper()) for one in seen)
    proven = np.isfinite(settled) and last.told < 1
    holds = proven and last.energy < floor, proven and last.equation < floor
    return len(seen), worst, drift, int(proven), *map(int, holds)


def bracket(device):
    """Two runs, one that snaps and one that never will, beside our own threshold."""
    from .enclosures import motion, passes

    model, (low, high) = build_model(device, "cosines", modes=3), AMPLITUDES
    until, rows, shown = SMALL if is_small() else SETTINGS.horizon, [], []
    for amplitude in few(AMPLITUDES):
        floor = passes.floor(model.modal, model.barrier)
        case = motion.equations(model, amplitude, **CASE)
        seen = motion.follow(case, model.barrier, floor, until)
        shown.append(seen.snaps)
        what = {True: "snaps", False: "never snaps", None: "open"}[seen.snaps]
        rows.append([f"{amplitude:.3f}", what, f"{seen.time:.2f}", f"{seen.radius:.0e}"])
        rest = "" if seen.snaps else f"{seen.rest:.2f}"
        rows[-1] += [f"{seen.growth:.0f}", str(seen.events), rest]
    head = ["N", "shown", "at, us", "radius", "digits lost", "contact events", "below barrier, pJ"]
    found = threshold(device, [CASE["f0"]], [CASE["C"]], model="cosines", modes=3)
    ours = f"{found.N_first.item():.3f}, with a bar of {found.N_error.item():.3f}"
    if shown == [False, True]:
        text = f"The threshold lies between {low:.3f} and {high:.3f}; both ends are proven. "
        return table(head, rows), text + f"Our `N_first`: {ours}."
    return table(head, rows), f"The bracket is not closed here. Our `N_first`: {ours}."


if __name__ == "__main__":
    main()
