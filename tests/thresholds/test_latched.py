"""From where on a device stays latched, against runs of the same model in other steps."""

import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap.device.device import batch
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.outcome import LATCHED, label
from snapmap.solver.settings import Settings
from snapmap.thresholds.settling import LONGER

F0, C = [400.0, 1500.0, 9000.0], [25.0, 200.0]


@pytest.fixture
def ringing(handout):
    return varied(handout, damping=5e-4)


def test_what_latches_from_a_shock_on_does_so_in_longer_steps_too(ringing):
    found = snapmap.threshold(ringing, F0, C, model="cosines", horizon=1500.0)
    lowest, highest = found.N_latched.values.ravel(), 2 * found.N_first.values.ravel()
    given = np.isfinite(lowest)
    assert given.any() and not given.all()
    model, settings = build_model(batch([ringing]), "cosines"), Settings(1500.0)
    rows = to_rows(0, np.tile(F0, 2), np.repeat(C, 3), 0, snapmap.pulse.shocks.HANDOUT_SHOCK.pulses)
    N = np.column_stack([lowest, highest])[given]
    for factor in (1.0, LONGER):
        cells = rows.take(given).cells(model.device, N, 1500.0)
        seen = model.with_step(factor).follow(cells, settings)
        latches = label(*seen[:4], settings.energy_tolerance) == LATCHED
        assert latches[:, 1].all() and (factor > 1 or latches.all())


def test_a_damped_beam_latches_wherever_it_snaps(handout):
    found = snapmap.threshold(varied(handout, damping=1e-2), F0[:2], C, model="cosines")
    np.testing.assert_array_equal(found.N_latched, found.N_first)
