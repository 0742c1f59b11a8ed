"""Other units of length, mass and time, and samples more than are needed, change no result."""

import math

import numpy as np
import pytest
import yaml
from small_studies import THREE_COSINES, cases_of, changed
from varied import varied

import snapmap
from snapmap import Study
from snapmap.applications.calibration.shots import read_shots, shots_from
from snapmap.applications.whole import load_config
from snapmap.beam.limit_loads import static_threshold
from snapmap.config.points import read_points
from snapmap.pulse.pulse import N_of_g, sampled
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap


def scaled(device, length, mass, time):
    """A similar device: every value multiplied by the power of its unit."""
    stiffness = mass / time**2
    factors = dict.fromkeys(("span", "rise", "thickness", "depth", "imperfection"), length)
    factors |= dict.fromkeys(("youngs_modulus", "residual_stress"), stiffness / length)
    factors |= {"density": mass / length**3, "damping": 1 / time}
    factors |= dict.fromkeys(("spring", "contact"), stiffness) | {"gap": length, "mass": mass}
    factors["gravity"] = length / time**2
    parts = {key: device.beam if hasattr(device.beam, key) else device for key in factors}
    return varied(device, **{key: factors[key] * getattr(parts[key], key) for key in factors})


@pytest.fixture(scope="module")
def device(handout):
    """One with a gap, residual stress and a damped beam."""
    return varied(handout, residual_stress=-8.0, damping=4e-3, gap=0.5)


@pytest.mark.parametrize("factors", [(3.0, 0.2, 7.0), (0.02, 50.0, 0.3)])
def test_similar_devices_answer_alike(device, factors):
    def ask(verb, length, mass, time, **values):
        rows = {"f0": np.array([400.0, 1500.0]) / time, "C": [200.0 * mass / time], **values}
        study = Study(scaled(device, length, mass, time), "3 cosines", horizon=1500.0 * time)
        return verb(study, **rows)

    N = [600.0, 900.0, 1300.0, 1800.0]
    cube, similar = (ask(snapmap.sweep, *each, N=N) for each in ((1, 1, 1), factors))
    assert 0 < cube.t_snap.notnull().sum() < cube.t_snap.size
    np.testing.assert_array_equal(similar.outcome, cube.outcome)
    for key in ("t_snap", "t_settled"):
        np.testing.assert_allclose(similar[key] / factors[2], cube[key], rtol=1e-12)
    edge, similar = (ask(snapmap.threshold, *each) for each in ((1, 1, 1), factors))
    for key in ("N_first", "N_always", "N_static", "N_bound"):
        np.testing.assert_allclose(similar[key], edge[key], rtol=1e-12)
    # At its threshold the time of a snap magnifies what rounding does to N.
    np.testing.assert_allclose(similar.t_snap / factors[2], edge.t_snap, rtol=1e-10)


@pytest.mark.parametrize(("key", "low", "high"), [("thickness", 1.0, 4.0), ("rise", 5.0, 30.0)])
@pytest.mark.parametrize("change", [{}, {"contact": np.inf}, {"spring": 1.0}, {"spring": 20.0}])
def test_thicker_and_higher_beams_need_more(handout, change, key, low, high):
    devices = [varied(handout, **change, **{key: value}) for value in np.linspace(low, high, 7)]
    assert (np.diff([static_threshold(device) for device in devices]) > 0).all()


def test_thresholds_of_many_swings_are_those_of_a_quarter_of_the_step(handout):
    """Each swing needs its own steps: with those of one, N is wrong by 0.1 % and more."""
    x = np.linspace(0, 1, 1601)
    beats = sampled(500 * x, np.sin(np.pi * x) ** 2 * (1 - np.cos(32 * np.pi * x)) / 2)
    assert beats.variation > 15
    model = build_model(handout, Cosines(modes=3))
    rows = to_rows(0, [1000.0, 2000.0], [[0.025], [200.0]], pulses=(beats,))
    static, settings = static_threshold(handout), Run(horizon=300.0, until="snap")
    probes = (Probe(each, rows, settings) for each in (model, model.with_step(0.25)))
    coarse, fine = (lowest_snap(probe, (0.5 * static, 6.0 * static), 1e-5) for probe in probes)
    np.testing.assert_allclose(coarse, fine, rtol=2e-4)


RATIO = 9.81


@pytest.fixture(scope="module")
def studies():
    """A study, and the same whose N counts multiples of 1 m/s^2."""
    document = yaml.safe_load(THREE_COSINES) | cases_of(__file__)
    shock = dict(document["requirements"][0], N=1100 * RATIO)
    other = changed(document, device__gravity="1 m/s^2", sweep__N=[900 * RATIO, 1100 * RATIO])
    return load_config(document), load_config(
        {**other, "requirements": [shock, *document["requirements"][1:]]}
    )


def test_another_unit_of_N_changes_no_verdict_and_no_margin(studies):
    def judged(study):
        required, C = study.requests["requirements"], [25.0]
        return [row for each in required for row in each.check(study.of_thresholds(), C)]

    in_g, in_m_s2 = map(judged, studies)
    assert {row.verdict for row in in_g} >= {"met", "failed"}
    for row, other in zip(in_g, in_m_s2, strict=True):
        by = 1.0 if row.shape in ("spectrum", "random") else RATIO
        assert (other.verdict, other.outcome) == (row.verdict, row.outcome)
        assert math.isclose(other.N, by * row.N, rel_tol=1e-9)
        assert abs(other.margin - row.margin) <= 0.1 * row.margin_error
    fall = in_g[1]
    assert fall.scale == pytest.approx(1) and fall.scale_first == pytest.approx(fall.margin)
    peak = math.sqrt(2 * 9.80665 * 3e-3) * math.pi / 2 / 0.05e-3
    assert math.isclose(fall.N, peak / 9.81, rel_tol=1e-9)
    for study, N in zip(studies, (fall.N, fall.N * RATIO), strict=True):
        pulse = study.requests["requirements"][1].shocks.pulse
        (line, *_) = pulse.doubts(1.0, pulse.duration, study.device.gravity)
        assert f"N = {N:.5g} is the fall from its height" in line


def test_a_shot_of_a_drop_has_the_level_of_its_height_in_the_unit_of_N(studies):
    of_drop = make_shocks({"drop": {"height": 3000.0, "duration": 50.0}})
    table = {"N": [math.nan, 1.0, 1e9], "tripped": [True, False, True]}
    shots = [shots_from(table, of_drop, study.device).N[0] for study in studies]
    assert shots[0] * 9.81e-6 == pytest.approx(of_drop.pulse.peak)
    assert shots[1] == pytest.approx(RATIO * shots[0])


def test_a_column_of_N_in_g_is_converted_to_the_unit_of_N(tmp_path, studies):
    """Where gravity is that of the earth, N counts multiples of g as they stand."""
    for name in ("points.csv", "shots.csv"):
        (tmp_path / name).write_text("N (g),f0 (Hz)\n1000,400\n", encoding="utf-8")
    for study, N in zip(studies, (1000.0, 9806.65), strict=True):
        of_g = N_of_g(study.device.gravity)
        (point,) = read_points(tmp_path / "points.csv", N_of_g=of_g)
        assert [point.N] == read_shots(tmp_path / "shots.csv", N_of_g=of_g)["N"] == pytest.approx(N)
