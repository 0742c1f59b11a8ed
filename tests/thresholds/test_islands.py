"""Islands that cheap levels do not see: maps and thresholds against eleven cosines."""

import numpy as np
import pytest

import snapmap
from snapmap.device.device import Beam, Device, batch
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.adaptive import UNCOMPARED
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import asker

COSINES = {"cosine_2": 0.0747, "cosine_3": 0.01195, "cosine_4": -0.0062, "cosine_5": -0.0213}
THIN = Beam(185.255, 1.915, 0.3642, 10.63, 121.9e3, 2.33e-3, 0.0063, -2.965, **COSINES)
STOPS = {"stop_toward": 1.778, "stop_away": 3.515, "restitution": 0.22}
MEASURED = Device(THIN, 735.0, 0.688, 56.9, 9.81e-6, **STOPS)
TILTS = Beam(480.0, 9.0, 1.5, 15.0, 165e3, 2.33e-3, imperfection=0.01, free=1.0)
TILTED = Device(TILTS, 6000.0, 2.0, 120.0, 9.81e-6)
BACK = {"start": "second", "pulse": make_pulse("half sine"), "horizon": 616.0}
THERE = {"start": "first", "pulse": make_pulse(), "horizon": 1500.0}


@pytest.mark.parametrize(
    ("device", "f0", "C", "how", "N"),
    [
        (MEASURED, 5e4, 139.7, BACK, np.linspace(185e3, 285e3, 21)),
        # Of 22 modes the kernel takes most of a minute to compile.
        pytest.param(
            *(TILTED, 9e3, 25.0, THERE, np.linspace(1041.0, 1131.0, 46)), marks=pytest.mark.long
        ),
    ],
)
def test_maps_and_thresholds_have_the_islands_of_eleven_cosines(device, f0, C, how, N):
    rows = to_rows(0, f0, C, 0, [how["pulse"]])
    settings = Settings(how["horizon"], start=how["start"])
    eleven = build_model(batch([device]), "cosines", modes=11)
    labels = [
        np.isfinite(asker(eleven.with_step(step), rows, settings)(N[np.newaxis])[0])
        for step in (1.0, 0.5)
    ]
    sure = labels[0] == labels[1]
    changes = np.count_nonzero(np.diff(labels[0]))
    assert changes >= 3 and sure.mean() > 0.6
    cube = snapmap.sweep(device, N, [f0], [C], until="snap", **how).squeeze()
    np.testing.assert_array_equal(cube.t_snap.notnull()[sure], labels[0][sure])
    assert ((cube.agreed == UNCOMPARED) == (cube.level == 0)).all()

    found = snapmap.threshold(device, [f0], [C], **how).squeeze()
    finer = np.geomspace(0.97, 1.02, 60) * found.N_first.item()
    snapped = np.isfinite(asker(eleven.with_step(0.5), rows, settings)(finer[np.newaxis])[0])
    first = finer[np.argmax(snapped)]
    assert found.ragged and not snapped[0] and snapped.any()
    assert abs(found.N_first - first) <= found.N_error < 0.02 * first
