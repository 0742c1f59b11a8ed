"""Derivatives of thresholds: exact on cubics, of their order, within their errors, similar."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from varied import in_steps

import snapmap
from snapmap.beam.limit_loads import static_threshold
from snapmap.device import batch
from snapmap.numerics.portable import linear
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings
from snapmap.thresholds.gradients import gradients, slopes
from studies.random_devices import draw_device

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}
TOLERANCE = 1e-4


def along(N, x, bars=0.0):
    return slopes(x, N(x), bars * N(x), TOLERANCE if bars else 0.0)


def test_the_derivative_of_a_cubic_is_exact_wherever_points_stand():
    x = np.array([0.0, 1.0, 1.5, 3.0, 4.0, 4.2, 7.0])
    slope, _ = along(lambda x: 30 + x - 2 * x * x + x * x * x / 3, x)
    np.testing.assert_allclose(slope, 1 - 4 * x + x * x, atol=1e-12)
    slope, _ = along(lambda x: 30 + x - 2 * x * x, x[:3])
    np.testing.assert_allclose(slope, 1 - 4 * x[:3], atol=1e-12)


def test_errors_are_of_third_order_and_known():
    far = []
    for points in (17, 33, 65):
        slope, error = along(np.exp, linear(0.0, 1.0, points))
        off = abs(slope - np.exp(linear(0.0, 1.0, points)))
        assert (off <= error).all()
        far.append(off.max())
    assert np.log2(far[0] / far[1]) > 2.8 and np.log2(far[1] / far[2]) > 2.8


@pytest.mark.parametrize("points", [5, 9, 33])
def test_errors_cover_the_truth_of_waves_with_bars(points):
    """What bars have in common shifts all points; the tolerance shifts each by itself."""
    draw, x, held = np.random.default_rng(1), linear(0.0, 1.0, points), []
    for _ in range(200):
        size, rate, phase = draw.normal(size=4), draw.uniform(0.5, 3.0, 4), draw.uniform(0, 6, 4)
        angle = rate * x[:, np.newaxis] + phase
        N, truth = 10 + (size * np.sin(angle)).sum(1), (size * rate * np.cos(angle)).sum(1)
        bars = N * draw.uniform(3, 6, points) * TOLERANCE
        shift = draw.choice([-3, 3]) + draw.uniform(-1, 1, points)
        slope, error = slopes(x, N * (1 + TOLERANCE * shift), bars, TOLERANCE)
        held += list(abs(slope - truth) <= error)
    assert np.mean(held) > 0.95


def test_static_thresholds_scale_with_all_stiffness(handout):
    """Exact: N g is proportional to stiffness, so the shares of E, K and contact add up to 1."""
    total, left_open, N = 0.0, 0.0, static_threshold(handout)
    for key in ("youngs_modulus", "spring", "contact"):
        own = getattr(handout.beam if key == "youngs_modulus" else handout, key)
        x = own * linear(0.9, 1.1, 9)
        values = static_threshold(batch([handout]).pick(np.zeros(9, int)).vary({key: x}))
        slope, error = slopes(x, values, 0 * values, 0.0)
        total, left_open = total + own * slope[4] / N, left_open + own * error[4] / N
    assert abs(total - 1) <= left_open < 1e-3


def test_thresholds_of_similar_devices_bind_their_gradients(handout):
    """Exact: in another unit of time E, K and contact are as C squared and f0 squared, and N g."""
    shock = {"f0": [1000.0], "C": [25.0]}
    total, left_open = 0.0, 0.0
    powers = {"youngs_modulus": 1, "spring": 1, "contact": 1, "C": 0.5, "f0": 0.5}
    for key, power in powers.items():
        place = {"youngs_modulus": handout.beam}.get(key, handout)
        own = shock[key][0] if key in shock else getattr(place, key)
        x = own * linear(0.9, 1.1, 5)
        found = snapmap.threshold(handout, **shock | {key: x}, **CHEAP).squeeze()
        if key == "f0":
            slope, error = slopes(x, found.N_first.values, found.N_error.values, TOLERANCE)
        else:
            slope, error = found[f"dN_d{key}"].values, found[f"dN_d{key}_error"].values
        N = found.N_first[2].item()
        total += power * own * slope[2] / N
        left_open += power * own * error[2] / N
    assert abs(total - 1) <= left_open < 0.05


def test_gradients_of_random_devices_lie_within_their_errors():
    """Against a finer model, between thresholds close by."""
    draw = np.random.default_rng(3)
    for _ in range(2):
        device = draw_device(draw)
        f0 = 0.3e6 * float(device.own_frequency) / (2 * np.pi)
        C, x = 0.5 * np.sqrt(device.spring * device.mass), linear(0.96, 1.04, 5)
        x *= device.beam.thickness
        found = snapmap.threshold(device, [f0], [C], thickness=x, **CHEAP).squeeze()
        beside = np.concatenate([0.998 * x, 1.002 * x])
        devices = batch([device]).pick(np.zeros(10, int)).vary({"thickness": beside})
        fine = in_steps(build_model(devices, "cosines", modes=5), 0.5)
        N = np.tile(found.N_first, 2)
        rows, ends = to_rows(np.arange(10), f0, C), (0.97 * N, 1.03 * N)
        low, high = lowest_snap(fine, rows, ends, Settings(300.0), 1e-6).reshape(2, 5)
        slope, error = found.dN_dthickness.values, found.dN_dthickness_error.values
        assert (abs(slope - (high - low) / (0.004 * x)) <= error).all()
        assert (error < 0.1 * slope).all()


def test_no_gradient_beside_rows_without_a_clean_threshold():
    axes = {"temperature": linear(0.0, 80.0, 9)[::-1], "C": np.array([1.0, 2.0, 4.0])}
    axes |= {"f0": np.array([100.0, 200.0, 300.0]), "rise": np.array([9.0, 10.0])}
    N = np.full((9, 3, 3, 2), 500.0) + axes["temperature"].reshape(9, 1, 1, 1) ** 2
    N[2, 0, 1] = np.nan
    made = gradients(axes, N, 1e-4 * N, TOLERANCE)
    assert set(made) == {
        f"dN_d{key}{end}" for key in ("temperature", "C") for end in ("", "_error")
    }
    (_, slope, about), (_, at_C, about_C) = made["dN_dtemperature"], made["dN_dC"]
    assert (about["units"], about_C["units"]) == ("K-1", "(uN us um-1)-1")
    lost = np.isnan(slope)
    assert not lost[:, 1:].any() and not lost[:, :, [0, 2]].any() and lost[1:4, 0, 1].all()
    assert not lost[[*range(6, 9)]].any()
    np.testing.assert_allclose(slope[8], 2 * axes["temperature"][8], atol=1e-9)
    assert np.isnan(at_C[2, :, 1]).all() and np.isfinite(np.delete(at_C, 2, axis=0)).all()


def test_gradients_are_those_of_the_points_there_are(handout):
    """Of reversed axes the same; not of an earlier file's points."""
    asked = {"f0": [1000.0], "C": [25.0], **CHEAP}
    x = linear(1.9, 2.1, 5)
    whole = snapmap.threshold(handout, thickness=x, **asked)
    again = snapmap.threshold(handout, thickness=x[::-1], earlier=whole, **asked)
    np.testing.assert_array_equal(again.dN_dthickness[::-1], whole.dN_dthickness)
    fewer = snapmap.threshold(handout, thickness=x[1:4], earlier=whole, **asked)
    alone = snapmap.threshold(handout, thickness=x[1:4], **asked)
    xr.testing.assert_identical(fewer, alone)
    two = snapmap.threshold(handout, thickness=x[:2], earlier=whole, **asked)
    assert not any(key.startswith("dN_d") for key in two)
    # N counts multiples of g.
    heavier = replace(handout, gravity=2 * handout.gravity)
    half = snapmap.threshold(heavier, thickness=x, **asked)
    np.testing.assert_allclose(2 * half.dN_dthickness, whole.dN_dthickness, rtol=1e-9)
