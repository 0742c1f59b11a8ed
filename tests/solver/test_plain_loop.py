"""The plain loop against exact motions, convergence orders and its energy ledger."""

import numpy as np
import pytest

from snapmap.beam.elements import hermite_elements
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.plain_loop import follow, nodal_system


def march(device, N, f0, C, dt, duration, target=-np.inf, change=lambda system: system):
    """Reference history at every step: t, u, du/dt, y, dy/dt, work, swept; and the results."""
    basis = hermite_elements(5)
    steps = int(np.ceil(duration / dt))
    history = np.zeros((steps, 2 * basis.load.size + 4))
    system = change(nodal_system(device, basis))
    shock = make_pulse().curve, N * device.gravity, f0
    result = follow(system, *shock, C, target, dt, steps, history)
    return np.arange(steps) * dt, history, result


def versed_sine_response(t, amplitude, f0, omega):
    """Undamped oscillator at rest under -amplitude/2 (1 - cos 2 pi f0 t), pulse over at 1/f0."""
    forcing, tau = 2 * np.pi * f0, 1 / f0

    def forced(t):
        steady = (1 - np.cos(omega * t)) / omega**2
        swing = (np.cos(forcing * t) - np.cos(omega * t)) / (omega**2 - forcing**2)
        return -amplitude / 2 * (steady - swing)

    return np.where(t < tau, forced(t), forced(t) - forced(t - tau))


@pytest.mark.parametrize("f0", [0.4e-3, 1.5e-3, 6e-3])
def test_a_mass_that_flies_away_is_a_linear_oscillator(handout, f0):
    """Negative N pulls the mass off the beam at once: closed form, eq. (2) with P = 0."""
    omega = np.sqrt(handout.spring / handout.mass)
    t, history, _ = march(handout, -30.0, f0, 0.0, 0.03, 1 / f0 + 50.0)
    exact = versed_sine_response(t, -30.0 * handout.gravity, f0, omega)
    flying = exact > 0.01 * exact.max()
    assert flying.mean() > 0.5
    # The beam follows the frame a little and touches at the very start; 1e-5 of the peak is all.
    np.testing.assert_allclose(history[:, 18][flying], exact[flying], atol=2e-5 * exact.max())


def test_order_two_in_the_step_before_first_separation(handout):
    duration, ends = 60.0, []
    for n in (2400, 4800, 9600, 19200):
        dt = duration / n
        _, history, _ = march(handout, 1000.0, 1.5e-3, 200.0, dt, duration + 1.5 * dt)
        assert history[n // 4 :, 18].max() < 0
        ends.append(history[n, [8, 18]])
    differences = np.abs(np.diff(ends, axis=0))
    assert np.log2(differences[:-1] / differences[1:]) == pytest.approx(2.0, abs=0.1)


def test_the_handouts_own_question(handout):
    """N = 1000 at 1500 Hz snaps; without the beam's own load, as in eq. (3), it would not."""
    w2 = handout.beam.second_equilibrium - handout.beam.rise
    asked = handout, 1000.0, 1.5e-3, 0.025, 0.0276, 2167.0, w2
    t_snap, *_ = march(*asked)[2]
    assert t_snap == pytest.approx(434.89, abs=0.02)
    t_snap, *_ = march(*asked, lambda system: system._replace(load=0 * system.load))[2]
    assert np.isnan(t_snap)


def test_the_ledger_closes_to_second_order_while_the_contact_holds_energy(handout):
    runs = (march(handout, 800.0, 1.5e-3, 25.0, dt, 300.0)[2] for dt in (0.03, 0.015))
    errors = [error for _, error, _ in runs]
    assert errors[0] < 1e-7 and errors[0] / errors[1] == pytest.approx(4, rel=0.1)
