"""The shock of a lane: each step of a block is the curve at that instant."""

import numpy as np
import pytest

from snapmap.numerics import pieces as curve
from snapmap.pulse.pulse import make_pulse, sampled, table
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out

X = np.sort(np.random.default_rng(4).uniform(0, 1, 300))
NOISE = np.random.default_rng(5).normal(size=300)
NOISE[-1] = 0.0
FEW = np.array([0.0, 0.3, 0.31, 1.0]), np.array([0.5, 1.0, -0.2, 0.01])
PULSES = {"record": sampled(X, NOISE), "few lines": sampled(*FEW)}
PULSES |= {"jump": make_pulse("sawtooth"), "lines": make_pulse("trapezoid")}


@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("x_step", [1 / 86, 1 / 512, 1 / 700.3])
def test_lines_are_sampled_as_the_curve_step_by_step(name, x_step):
    pulses, amplitude = table([make_pulse(), PULSES[name]]), -1234.5
    pieces, bounds, jumps = pulses
    work, state, shocks = np.zeros(R.VECTORS * R.LANES), no_pulse(), np.zeros(BLOCK * R.LANES)
    work[R.AMPLITUDE * R.LANES + 3] = amplitude
    begin_pulse(work, 3, state, pulses, 1, x_step)
    k = bounds[1]
    while state.steps[3] < state.lasts[3]:
        set_out(work, shocks, state, pulses)
        seen, exact = shocks.reshape(BLOCK, R.LANES)[:, 3], np.empty(BLOCK)
        for i in range(BLOCK):
            x = x_step * (state.steps[3] + i)
            k = curve.at(pieces, k, bounds[2], x)
            exact[i] = amplitude * curve.sample(pieces, k, tuple(jumps[1]), x, x_step)
        np.testing.assert_allclose(seen, exact, rtol=1e-12, atol=1e-9)
        # Every block of the record has a joint; others go on from step to step.
        assert name != "record" or seen.tobytes() == exact.tobytes()
        state.steps[3] += BLOCK
