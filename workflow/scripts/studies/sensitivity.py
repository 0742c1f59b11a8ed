"""How the threshold moves with the device, and how much the beam is stressed: docs/limits.md.

PYTHONPATH=workflow/scripts ./run python -m studies.sensitivity [--small]
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from snapmap import load_device, simulate, threshold
from snapmap.curved_beam import SIZES
from snapmap.device import batch
from snapmap.io.markdown import table
from snapmap.solver.adaptive import choose_survey
from snapmap.solver.cells import to_rows
from snapmap.solver.settings import Settings
from snapmap.thresholds.islands import survey

from .few import few

ROOT = Path(__file__).resolve().parents[3]
OF_BEAM = SIZES
OF_DEVICE = ("mass", "spring", "contact")
COSINES = {"name": "cosines", "modes": 5}
GAPS = [0.0, 0.5, 1.0, 2.0]
STOPS = [(np.inf, np.inf, 0.5), (15.0, 6.0, 0.5), (15.0, 6.0, 0.9), (10.0, 6.0, 0.5)]
BLOWS = [1500.0, 5000.0, 30000.0]
MODELS = [
    *({"model": "cosines", "modes": modes} for modes in (3, 5, 11, 21)),
    *({"model": "reference", "elements": elements} for elements in (5, 10)),
]
F0, C, TOLERANCE = 1500.0, 0.025, 1e-6


def main():
    device = load_device(ROOT / "config" / "config.yaml")
    print(one_percent_more(device))
    print(eigenstrain(device))
    print(gaps(device))
    print(stops(device))
    print(stresses(device))


def one_percent_more(device):
    beam = device.beam
    changed = {"as it is": device}
    for key in few(OF_BEAM):
        changed[key] = replace(device, beam=replace(beam, **{key: 1.01 * getattr(beam, key)}))
    for key in few(OF_DEVICE):
        changed[key] = replace(device, **{key: 1.01 * getattr(device, key)})
    changed["damping 4e-4 /us"] = replace(device, beam=replace(beam, damping=4e-4))
    asked = {"f0": [F0], "model": COSINES, "tolerance": TOLERANCE}
    found = threshold(changed, C=[C], **asked).N_first.values.ravel()
    heavier = replace(device, gravity=1.01 * device.gravity)
    others = threshold(heavier, C=[C], **asked), threshold(device, C=[25.0, 200.0], **asked)
    more = [N for other in others for N in other.N_first.values.ravel()]
    names = [*changed, "gravity", "C = 25", "C = 200"][1:]
    rows = [["as it is", f"{found[0]:.2f}"]]
    for name, N in zip(names, [*found[1:], *more], strict=True):
        rows.append([name, f"{100 * (N / found[0] - 1):+.3f} %"])
    return table(["1 % more of", "N_first"], rows)


def eigenstrain(device):
    """Thresholds with an eigenstrain e, that is a residual stress of -E e."""
    first, rows = None, []
    row = to_rows(0, F0, C)
    for strain in few((0.0, 1e-5, -1e-5, 1e-4, -1e-4), 2):
        stress = -strain * device.beam.youngs_modulus
        strained = replace(device, beam=replace(device.beam, residual_stress=stress))
        models = choose_survey(batch([strained]), COSINES)
        found = survey(models, row, Settings(), TOLERANCE).N_first[0]
        first = first or found
        rise = strained.beam.height / device.beam.rise - 1
        rows.append([f"{strain:g}", f"{100 * rise:+.3f} %", f"{100 * (found / first - 1):+.2f} %"])
    return table(["eigenstrain", "rise", "N_first"], rows)


def gaps(device):
    """Thresholds with a gap between mass and beam."""
    found = threshold(device, [F0], [C], model=COSINES, tolerance=TOLERANCE, gap=few(GAPS))
    rows = zip(few(GAPS), found.N_first.values.ravel(), strict=True)
    return table(["gap, um", "N_first"], [[f"{gap:g}", f"{N:.1f}"] for gap, N in rows])


def stops(device):
    """Thresholds along +z and -z with stops, C = 25."""
    rows = []
    for toward, away, e in few(STOPS):
        held = replace(device, stop_toward=toward, stop_away=away, restitution=e)
        found = threshold(held, few(BLOWS), [25.0], direction="both").squeeze("C")
        numbers = found.N_first.transpose("direction", "f0").values.ravel()
        told = ["none" if np.isnan(N) else f"{N:.0f}" for N in numbers]
        rows.append([f"{toward:g} µm", f"{away:g} µm", f"{e:g}", *told])
    blows = [f"{way} {f0:g} Hz" for way in ("+z", "−z") for f0 in few(BLOWS)]
    return table(["toward", "away", "restitution", *blows], rows)


def stresses(device):
    """Largest stress up to the snap, and to the horizon, with several models."""
    rows = []
    for N in few((984, 1000, 1500, 2400)):
        runs = [simulate(device, N, F0, C, **model) for model in few(MODELS)]
        found = [f"{run.stress_max_to_snap:.1f} / {run.stress_max:.0f}" for run in runs]
        rows.append([f"{N}", *found])
    names = [" ".join(map(str, model.values())) for model in few(MODELS)]
    return table(["N", *names], rows)


if __name__ == "__main__":
    main()
