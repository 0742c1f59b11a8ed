"""How far from a clean threshold a label of a map is wrong, for docs/accuracy.md.

./run python -m studies labels [--small]
"""

import numpy as np

from snapmap import Study, sweep
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines, Elements
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import clean_rows, command_device, few, number
from .tables import Table, write

F0, C = np.geomspace(300.0, 3e4, 41), (25.0, 200.0)
MODELS = {
    "auto": Auto(),
    "3 cosines": Cosines(modes=3),
    "5 cosines": Cosines(modes=5),
    "11 cosines": Cosines(modes=11),
    "5 elements": Elements(),
}
TRUE, STEP, NEAR, TOLERANCE = Cosines(modes=16), 0.125, 0.02, 1e-6
"""The model of the true thresholds, its step over the default one, within which relative distance
of others' thresholds it seeks them, and how closely."""
AROUND = np.concatenate([sign * np.geomspace(3e-5, 2e-2, 41)[::sign] for sign in (-1, 1)])
"""Relative distances of N from the true threshold."""
HEAD = ["model", "`label_distance`, %", "clean thresholds", "of these beyond it"]
HEAD += ["labels change within, median, %", "90 %", "largest"]


def main():
    device = command_device()
    rows = true_thresholds(device)
    write("labels", Table("labels", HEAD, [row(device, rows, name) for name in few(MODELS, 2)]))


def true_thresholds(device):
    """Find f0 (Hz), C (uN us/um) and the true threshold of rows that are not ragged, (3, rows)."""
    f0, damping, N = clean_rows(device, few(F0), few(C))
    probe = Probe(build_model(device, TRUE).with_step(STEP), to_rows(0, f0, damping), Run())
    true = lowest_snap(probe, (N * (1 - NEAR), N * (1 + NEAR)), TOLERANCE, NEAR / 8)
    return np.array([f0, damping, true])[:, np.isfinite(true)]


def row(device, rows, name):
    """Write how far the wrong labels of a model reach from the threshold, over clean rows."""
    study = Study(device, MODELS[name], until="snap")
    reach = []
    for f0, damping, true in rows.T:
        cube = sweep(study, true * (1 + AROUND), [f0], [damping])
        wrong = np.isfinite(cube.t_snap.values.ravel()) != (AROUND > 0)
        reach.append(100 * np.max(abs(AROUND), where=wrong, initial=0.0))
    distance = 100 * cube.t_snap.attrs["label_distance"]
    counts = f"{distance:g}", len(reach), np.sum(np.array(reach) > distance)
    return [name, *map(str, counts), *map(number, np.quantile(reach, [0.5, 0.9, 1.0]))]
