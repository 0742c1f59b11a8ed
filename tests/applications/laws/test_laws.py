"""The three laws beside thresholds, and their figure."""

from contextlib import nullcontext
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.linalg import eigh
from scipy.optimize import brentq
from small_results import visible
from varied import varied

import snapmap
from snapmap.applications.laws import application
from snapmap.applications.laws.figure import draw as draw_laws
from snapmap.applications.laws.laws import _obstacle, _snap_scales, laws_of, saddle_rates, summary
from snapmap.beam.cosines import symmetric_cosines
from snapmap.figures import style
from snapmap.pulse.pulse import make_pulse
from snapmap.study.study import Study
from snapmap.thresholds.probe import Probe

AXES = {"C": [25.0], "f0": [50.0, 2e4]}


@pytest.fixture(scope="module")
def laws(handout):
    study = Study(device=handout, model={"name": "cosines", "modes": 5})
    thresholds = snapmap.threshold(Study(handout, "5 cosines"), **AXES)
    return laws_of(study, study.set_out(AXES), thresholds)


@pytest.mark.equation(46)
def test_snaps_of_clean_fast_rows_are_delayed_as_the_saddle_with_a_negative_second_mode_says(laws):
    """1.685 us in five cosines, within 2 % of the exact 1.683; and slow ones by half the dwell."""
    slow, fast = laws.snap_scale.values[0]
    assert fast == pytest.approx(1.683, rel=0.02)
    assert slow == pytest.approx(laws.dwell.item() / 2, rel=0.1)
    assert laws.saddle_scale.values == pytest.approx([1.68315, 2.20096], abs=5e-4)


@pytest.mark.equation(46)
@pytest.mark.parametrize("part", [0.0, 0.06, -0.06])
@pytest.mark.parametrize("cosines", [2, 3, 5, 11])
def test_a_saddle_is_left_at_two_rates_first_that_with_a_negative_second_mode(
    handout, cosines, part
):
    """By (4) in phi_n at EI = L = 1: c_n = made_n/(1 - N/N_n) near N_2, and mirrored there."""
    beam = varied(handout, cosine_2=part).beam
    wave = (2 * pi * np.arange(1, cosines + 1)) ** 2
    made, axial = np.zeros(cosines), 6 * (beam.rise / beam.thickness) ** 2
    made[:2] = 0.5, part / 2

    def saddle(c_2):
        N = wave[1] * (1 - made[1] / c_2)
        c = made / (1 - N / wave + 1e-99)  # 0/0 = 0
        c[1] = c_2
        return c, N - axial * (wave @ (made**2 - c**2)) / 2

    side, expected = np.copysign(1, part), []
    c, _ = saddle(side * brentq(lambda c_2: saddle(side * c_2)[1], 0.1, 1))
    for sign in (-1, 1):
        c[1] = sign * abs(c[1])
        N = axial * (wave @ (made**2 - c**2)) / 2
        slope = wave / 2 * c
        tangent = np.diag(wave**2 / 2 - N * wave / 2) + 2 * axial * np.outer(slope, slope)
        expected.append(-eigh(tangent, 1 + np.eye(cosines) / 2)[0][0])
    unit = beam.stiffness_unit / beam.weight
    rates = saddle_rates(beam, symmetric_cosines(cosines))
    assert rates == pytest.approx(np.sqrt(np.array(expected) * unit), rel=1e-7)


@pytest.mark.usefixtures("paper")
def test_limits_hold_where_thresholds_are_within_1_percent_and_are_broad_there(laws):
    assert laws.slow_to.item() == 50.0 and np.isnan(laws.short_from)
    v = laws.N_short * 9.81e-6 * 0.5 / (1e-6 * laws.f0)
    np.testing.assert_allclose(v, laws.velocity_change.item(), rtol=1e-12)
    words = summary(laws)
    assert "C = 25 " in words and "1.683 us later" in words
    assert "a slow shock trips it above N = 936.8 for longer than 147.9 us" in words
    draw_laws(figure := style.double_column(4.6), laws)
    top, below = figure.axes
    N_first = laws.N_first.values
    assert top.get_ylim() == pytest.approx((N_first.min() / 1.2, N_first.max() * 1.2))
    broad = [visible(line) for line in top.lines if line.get_linewidth() == 4]
    assert broad == [[[50.0, laws.N_slow.values[0, 0]]], []]
    levels = {line.get_ydata()[0] for line in below.lines[1:]}
    assert levels == {laws.dwell.item() / 2, *laws.saddle_scale.values}
    draw_laws(figure := style.double_column(4.6), laws.assign(N_slow=laws.N_slow * np.nan))
    words = {text.get_text() for text in figure.legends[0].get_texts()}
    assert not {word for word in words if "law" in word or "holds" in word}


def test_snaps_are_timed_over_decades_above_thresholds_in_brackets_of_their_errors(
    handout, monkeypatch
):
    """Where they are known; t = -s ln(N/N* - 1) gives back s."""
    scale, exact, asked = 1 + np.arange(3.0), 1000 + np.arange(3.0), []

    def lowest(probe, *given):
        asked.extend([probe.rows.f0, probe.rows.C, *given])
        return exact

    def t_snap(probe, N):
        above = (N.T - exact) / exact
        assert above[[0, -1]] == pytest.approx(np.repeat([[1e-4], [1e-8]], 3, axis=1), rel=1e-4)
        return -(scale * np.log(above)).T

    monkeypatch.setattr("snapmap.applications.laws.laws.lowest_snap", lowest)
    monkeypatch.setattr(Probe, "__call__", t_snap)
    study, N_first = Study(handout, "3 cosines"), [[1000.0, np.nan], [1001.0, 1002.0]]
    found = xr.Dataset({"N_first": (("C", "f0"), N_first)}, {"C": [25, 200], "f0": [50, 100]})
    found["N_error"] = found.N_first / 100
    scales = _snap_scales(study, study.set_out(AXES).device, make_pulse(), found)
    np.testing.assert_allclose(scales, [[1, np.nan], [2, 3]], rtol=1e-5)
    assert asked[0].tolist() == [50, 50, 100] and asked[1].tolist() == [25, 200, 200]
    np.testing.assert_allclose(asked[2], np.outer([0.989, 1.011], exact))
    assert asked[3:] == [1e-10, 2e-4]


@pytest.mark.usefixtures("paper")
def test_laws_hold_up_to_and_from_the_frequencies_at_which_they_are_off(handout, monkeypatch):
    """To 1 %, without a gap, at the first place on all other axes."""
    scales = lambda *given: np.ones(given[3].N_first.shape)  # noqa: E731
    monkeypatch.setattr("snapmap.applications.laws.laws._snap_scales", scales)
    axes = {"C": [25.0], "f0": [50.0, 100.0, 200.0, 300.0, 1e4, 2e4, 4e4]}
    short = 0.5e-6 * np.array(axes["f0"]) / (9.81e-6 * 0.5)
    N_first = np.append([900, 908.9, 910, 900.5], short[4:] * [1.02, 1.0099, 1.0])
    found = {"N_first": (("C", "f0"), [N_first]), "N_static": 890.0, "area": 0.5}
    found |= {"dwell": ("C", [150.0]), "velocity_change": ("C", [0.5]), "gravity": 9.81e-6}
    found["N_slow"] = ("C", "f0"), np.full((1, 7), 900.0)
    found = xr.Dataset(found, axes | {"C": ("C", [25.0], {"units": "uN us um-1"})})
    found["N_first"] = found.N_first * xr.DataArray([1.0, 2.0], dims="thickness")
    study = Study(handout, "3 cosines")
    laws = laws_of(study, study.set_out(axes), found)
    assert (laws.slow_to.item(), laws.short_from.item()) == (100.0, 2e4)
    np.testing.assert_allclose(laws.N_short[0], short)
    draw_laws(figure := style.double_column(4.6), laws)
    _, *lines = figure.axes[0].lines
    f0 = [[f for f, _ in visible(line)] for line in lines]
    assert f0 == [axes["f0"][:5], [50.0, 100.0, 300.0], axes["f0"][4:], [2e4, 4e4]]
    assert "no law" not in figure.legends[0].get_title().get_text() and laws.dwell.missing_as == ""
    none = laws[["N_static", "velocity_change", "saddle_scale"]] * np.nan
    words = "no law of slow shocks holds; no law of short shocks holds"
    assert summary(laws.assign(none)).endswith(f": {words}")
    laws["dwell"] = ("C", [np.nan], {"missing_as": "it is free"})
    assert "N = 890, how long is not known: it is free; a short one" in summary(laws)
    draw_laws(figure := style.double_column(4.6), laws)
    words = figure.legends[0].get_title().get_text()
    assert words.endswith("\nno law of slow shocks: it is free")


@pytest.mark.parametrize(("asked", "own"), [(True, None), (False, "laws.py"), (True, "laws.py")])
def test_three_laws_stand_beside_no_law_of_the_user(asked, own):
    study = SimpleNamespace(model=SimpleNamespace(laws=own), start="second")
    obstacle = "a law of the user's own acts" if own else "runs begin in the second shape"
    assert _obstacle(study, None) == obstacle
    with pytest.raises(ValueError, match="leave one of") if asked and own else nullcontext():
        assert application.request(asked, study, None) is asked
