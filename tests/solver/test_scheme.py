"""The conserving scheme, equation by equation: the kernel's own motions solve those of the page."""

import conserving_loop
import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap.applications.histories.motion import record
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.models import build_model

DEVICES = {"soft": {}, "hard": {"contact": np.inf}}
DEVICES["gap, damped"] = {"gap": 1.0, "contact": 4000.0, "damping": 4e-3}
DEVICES["tilting"] = {"free": 1.0, "imperfection": 0.05, "residual_stress": -8.0}
N, F0, C, DT, STEPS = 3000.0, 2e4, 25.0, 0.2, 300


class Recorded:
    """A run of the kernel, p and y at every instant, and what the page makes of them."""

    def __init__(self, device):
        model = build_model(device, snapmap.Cosines(modes=3))
        pulse, amplitude = make_pulse("half sine"), N * device.gravity
        cell = conserving_loop.one_cell(device, pulse, N, F0, C, DT, STEPS)
        _, (_, motion) = record(model, *cell)
        self.device, self.motion = device, motion
        self.kappa, self.S, self.Sq0, self.f, self.e, self.axial, c, _ = model.modal
        self.k = 1 / (1 / device.contact + c)
        at = (motion.u, motion.u_velocity), (motion.y, motion.y_velocity)
        self.p, self.y = (np.append(m[:1] - v[:1] * DT / 2, m + v * DT / 2, 0) for m, v in at)
        shares = [conserving_loop.sample(pulse, F0 * 1e-6, n, DT) for n in range(1, STEPS)]
        self.a = amplitude * np.array(shares)
        p, y = self.p, self.y
        self.q = np.sum(p[:-1] @ self.S * p[1:], axis=1) + (p[:-1] + p[1:]) @ self.Sq0
        self.x = (p[:-1] + p[1:]) @ self.e / 2 - (y[:-1] + y[1:]) / 2 - device.gap
        self.x_kept = np.maximum(self.x, 0.0)
        self.axial_force = -self.axial * (self.q[1:] + self.q[:-1]) / 2
        moved = np.diff(self.x)
        self.P = self.k / 2 * np.diff(self.x_kept**2) / np.where(moved == 0, 1, moved)
        x = np.minimum(np.sqrt(self.kappa) * DT, 2.0)
        self.g = (x / 2 / np.tan(x / 2)) ** 2
        self.G = self.g + self.kappa * DT**2 / 4

    def energy(self):
        """H at every half step."""
        p, y, dp, dy = self.motion.u, self.motion.y, np.diff(self.p, axis=0), np.diff(self.y)
        moving = dp**2 @ self.g + self.device.mass * dy**2
        bent = p**2 @ self.kappa + self.device.spring * y**2
        stretched, pressed = self.axial / 4 * self.q**2, self.k / 2 * self.x_kept**2
        return moving / (2 * DT**2) + bent / 2 + stretched + pressed


@pytest.fixture(scope="module", params=DEVICES)
def run(request, handout):
    run = Recorded(varied(handout, **DEVICES[request.param]))
    assert run.P.max() > 1 and np.diff(run.x > 0).any() and abs(run.axial_force).max() > 1
    return run


def assert_zero(residual, *terms):
    np.testing.assert_allclose(residual, 0, atol=1e-9 * max(abs(term).max() for term in terms))


@pytest.mark.equation(29, 34)
def test_stretch_and_overlap_are_taken_half_way_and_change_by_the_work_of_their_forces(run):
    assert_zero(run.q - run.motion.stretch, run.q)
    both, y_both = run.p[2:] - run.p[:-2], run.y[2:] - run.y[:-2]
    u = run.p[1:-1] @ run.S + run.Sq0
    assert_zero(np.sum(u * both, axis=1) - np.diff(run.q), run.q)
    assert_zero(both @ run.e / 2 - y_both / 2 - np.diff(run.x), run.x)


@pytest.mark.equation(30, 31, 32)
def test_the_kernels_motion_solves_both_forms_of_the_scheme(run):
    alpha, M, K = run.device.beam.damping, run.device.mass, run.device.spring
    p, y, a = run.p[1:-1], run.y[1:-1], run.a[:, np.newaxis]
    bend, rate = (run.p[2:] - 2 * p + run.p[:-2]) / DT**2, (run.p[2:] - run.p[:-2]) / (2 * DT)
    y_bend, y_rate = np.diff(run.y, 2) / DT**2, (run.y[2:] - run.y[:-2]) / (2 * DT)
    p_mean, y_mean = p + DT**2 / 4 * bend, y + DT**2 / 4 * y_bend
    pushes = run.axial_force[:, np.newaxis] * (p @ run.S + run.Sq0) - run.f * a
    pushes = pushes - run.e * run.P[:, np.newaxis]
    light = run.g * bend + alpha * run.G * rate + run.kappa * p_mean - pushes
    heavy = run.G * (bend + alpha * rate) + run.kappa * p - pushes
    assert_zero(light, pushes)
    assert_zero(heavy, pushes)
    assert_zero(M * y_bend + C * y_rate - run.P + M * run.a + K * y_mean, M * run.a)


@pytest.mark.equation(33, 35)
def test_the_energy_changes_by_the_work_of_the_pulse_less_the_losses(run):
    H, M = run.energy(), run.device.mass
    both, y_both = run.p[2:] - run.p[:-2], run.y[2:] - run.y[:-2]
    work = -run.a / 2 * (both @ run.f + M * y_both)
    lost = (run.device.beam.damping * both**2 @ run.G + C * y_both**2) / (4 * DT)
    assert_zero(np.diff(H) - work + lost, H)
    balance = H - run.motion.work + run.motion.lost
    assert_zero(balance - balance[0], H)
    assert work.max() > 0 and lost.min() >= 0


@pytest.mark.equation(39)
def test_the_energy_without_tension_is_no_more_than_that_of_the_step(run):
    p = run.motion.u
    Q = np.sum(p @ run.S * p, axis=1) + 2 * p @ run.Sq0
    least = p**2 @ run.kappa / 2 + run.axial / 4 * np.minimum(Q, 0.0) ** 2
    energy = run.energy()
    assert (least <= energy + 1e-12 * energy.max()).all() and least.max() > 0.1 * energy.max()
    assert (run.q <= Q + 1e-12 * abs(Q).max()).all()


@pytest.mark.equation(38)
def test_the_four_cases_of_contact_are_the_root_of_one_equation():
    draw, k, seen = np.random.default_rng(5), 40.0, set()
    for m, F, h in zip(*draw.normal(size=(2, 400)), draw.exponential(size=400), strict=True):
        x = conserving_loop.overlap(m, F, h)
        P = k / 2 * (max(x, 0.0) ** 2 - max(m, 0.0) ** 2) / (x - m)
        assert x + 2 * h / k * P == pytest.approx(F, abs=1e-9 * (1 + h))
        seen.add((m > 0, x > 0))
    assert len(seen) == 4
