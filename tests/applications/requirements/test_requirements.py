"""Shocks that must or must not trip: their verdicts, what would mend them, and their figure."""

import itertools
from contextlib import nullcontext
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest
import yaml
from matplotlib.collections import LineCollection
from small_results import artists, drawn, legend_words, make_verdict
from small_studies import THREE_COSINES, cases_of, changed, faults

import snapmap
from snapmap.applications.requirements import application, figure, left_out
from snapmap.applications.requirements.check import _is_close, check, judge
from snapmap.applications.requirements.summary import restless, summary, worst
from snapmap.applications.requirements.verdict import corners, read_verdicts, write_verdicts
from snapmap.applications.whole import load_config
from snapmap.figures import style
from snapmap.pulse.pulse import make_pulse
from snapmap.pulse.shocks import make_shocks
from snapmap.study.shock import Shock
from snapmap.study.study import Study

CASES = cases_of(__file__)


def test_verdicts_follow_from_the_threshold_of_the_required_pulse(handout, study):
    record = replace(make_pulse("half sine"), peak=100 * handout.gravity)  # of a record of 100 g
    threshold = snapmap.threshold(Study(handout, pulse=record, horizon=300.0), [2000.0], [25.0])
    first, error = threshold.N_first.item(), threshold.N_error.item()
    assert threshold.scale_first.item() == pytest.approx(first / 100)
    amounts = {"below": 0.99 * first, "at": first, "in the bar below": first - error / 2}
    amounts["above"] = 1.01 * first
    pulse = {"shocks": make_shocks(record), "f0": 2000.0}
    each = itertools.product(amounts.items(), ("arrives", False, "any"))
    asked = [Shock(name=f"{name} {must}", N=N, snaps=must, **pulse) for (name, N), must in each]
    verdicts = check(Study(handout, **vars(study.run)), asked, [25.0])
    close = ["unclear", "unclear", "met"]
    expected = ["failed", "met", "met", *close, *close, "met", "failed", "met"]
    assert [verdict.verdict for verdict in verdicts] == expected
    for verdict, N in zip(verdicts, np.repeat([*amounts.values()], 3), strict=True):
        assert (verdict.N_first, verdict.N_error) == (first, error)
        scaled = verdict.margin, verdict.scale, verdict.scale_first
        assert scaled == pytest.approx((first / N, N / 100, first / 100))
        assert (verdict.duration, verdict.shape, verdict.direction) == (0.5, "half sine", "+z")
    line = "6 of 12 requirements met; failed: below arrives, above False; unclear: at"
    assert summary(verdicts).startswith(line)
    furthest, words = worst(verdicts)
    off = {v.requirement: abs(np.log(v.margin)) for v in verdicts if v.verdict == "failed"}
    assert off[furthest.requirement] == max(off.values())
    side = "not sensitive enough" if furthest.must_snap else "too sensitive"
    assert f"{side}, trips" in words


@pytest.mark.parametrize(("values", "is_close"), CASES["close"])
def test_an_amplitude_within_the_bar_or_the_ragged_range_is_too_close(values, is_close):
    assert _is_close(*values) is is_close


@pytest.mark.parametrize(("values", "words"), CASES["corners"])
def test_a_corner_has_its_device_shock_and_temperature_in_words(values, words):
    assert make_verdict(**values).corner == words


def test_a_verdict_is_unclear_up_to_the_last_snap_of_a_ragged_row(handout, study):
    row = snapmap.threshold(Study(handout, study.model, horizon=300.0), [4000.0], [0.025]).squeeze()
    gap, bar = (row.N_always - row.N_first).item(), row.N_error.item()
    assert row.ragged and gap > 0
    ragged = {"N": (row.N_first + bar + gap / 2).item(), "f0": 4000.0, "shocks": study.shocks}
    (verdict,) = check(study, [Shock(name="ragged", snaps=True, **ragged)], [0.025])
    assert verdict.verdict == "unclear"


def test_a_requirement_counts_under_each_shock_at_each_temperature(handout, study):
    """The verdict is the worst one; a shock that may trip or not has none of the trip."""
    device, degrees = replace(handout, modulus_slope=-1e-3), [-40.0, 120.0]
    shapes = {"pulse": ["half sine", "versed sine"], "direction": "both"}
    how = {"model": study.model, "horizon": 300.0, **shapes}
    axes = {"temperature": degrees}
    found = snapmap.threshold(Study(device, **how), [2000.0], [25.0], axes=axes)
    thresholds = found.N_first.squeeze(["C", "f0"])
    N = float(np.sqrt(thresholds.min() * thresholds.max()))
    shocks = make_shocks(*shapes.values())
    required = Shock(name="launch", N=N, snaps="arrives", f0=2000.0, shocks=shocks)
    needs = [required, replace(required, name="set back", snaps="any")]
    verdicts = check(replace(study, device=device), needs, [25.0], temperatures=degrees)
    launch, back = verdicts[:8], verdicts[8:]
    places = [(v.temperature, v.shape, v.direction) for v in launch]
    assert len({*places}) == 8
    for verdict, (temperature, shape, direction) in zip(launch, places, strict=True):
        first = thresholds.sel(temperature=temperature, shape=shape, direction=direction).item()
        assert verdict.N_first == pytest.approx(first, rel=1e-4)
        assert verdict.verdict == ("met" if first < N else "failed")
    assert summary(launch) == "0 of 1 requirements met; failed: launch"
    last, words = worst(launch)
    assert last == max(launch, key=lambda verdict: verdict.margin)
    place = f"{last.shape} {last.direction}, 0.5 ms"
    assert f"launch, {place}, C = 25, {last.temperature:g} degC" in words
    ((front, *rest),) = corners(launch)
    assert front.N_first == last.N_first and len(rest) == 7
    assert {verdict.verdict for verdict in back} == {"met"} and worst(back) == (None, "")


@pytest.mark.parametrize(("strength", "stress", "must", "verdict"), CASES["judged"])
def test_a_requirement_fails_if_the_beam_breaks(handout, strength, stress, must, verdict):
    judged = judge(make_verdict(stress_max=stress), replace(handout, **strength), must)
    assert judged.verdict == verdict and judged.must_survive == must
    if "strength_modulus" not in strength and strength:
        assert judged.strength_margin == pytest.approx(1500 / stress)
        assert judged.break_probability == (stress > 1500)
    assert np.isnan(judged.strength_margin) == (not strength)


@pytest.mark.parametrize(("changes", "required", "expected"), CASES["sections"])
def test_a_requirement_has_the_pulse_of_its_study(changes, required, expected):
    """But for what it writes; or it is refused; a drop gives the N itself."""
    document = changed(yaml.safe_load(THREE_COSINES), **CASES["study"] | changes)
    required = required if isinstance(required, list) else [required]
    document["requirements"] = [{"name": "a", "snaps": False} | one for one in required]
    if isinstance(expected, str):
        (line,) = faults(document)
        assert line.startswith(expected)
    else:
        (shock,) = load_config(document).requests["requirements"]
        if isinstance(expected, dict):
            assert shock.shocks.pulse.section == expected
            return
        assert [[one.pulse.name, one.direction] for one in shock.shocks.each()] == expected
        assert (required[0].get("N") or shock.shocks.pulse.peak / 9.81e-6) == shock.N


def test_a_yield_leaves_out_spectra_and_closings():
    more = CASES["study"] | CASES["left out"]
    study = load_config(changed(yaml.safe_load(THREE_COSINES), **more))
    assert left_out(study) == ["srs", "the closing of crash"]


def test_the_worst_corner_is_in_front():
    """What is violated before what is unclear; a strength counts if the beam must survive."""
    margins = {"met": 1.01, "unclear": 0.5, "failed": 0.9}
    rows = [make_verdict(verdict=word, margin=margin) for word, margin in margins.items()]
    for order in itertools.permutations(rows):
        ((*group,),) = corners(order)
        assert [row.verdict for row in group] == ["failed", "unclear", "met"]
    free = make_verdict(must_snap="any", margin=0.1, strength_margin=0.2, more={"x_margin": 1.5})
    for must_survive, reserve in ((0.0, 1.5), (0.999, 0.2), (np.nan, 1.5)):
        assert replace(free, must_survive=must_survive).badness == (0, 0.0, -reserve)


@pytest.mark.parametrize(("strength", "breaks"), [("1 MPa", True), ("100 GPa", False)])
def test_the_closing_line_says_where_the_beam_breaks(tmp_path, capsys, strength, breaks):
    """A shock far below the threshold fails by the strength alone, and the line says so."""
    needs = {"name": "handling", "N": 50, "f0": "1 kHz", "snaps": False, "survives": True}
    more = CASES["study"] | {"device__strength": strength, "requirements": [needs]}
    study = load_config(changed(yaml.safe_load(THREE_COSINES), **more))
    application.run(study, tmp_path / "requirements.csv")
    line = capsys.readouterr().out
    assert ("the beam breaks in handling" in line) == breaks == ("failed: handling" in line)


def test_verdicts_are_read_as_they_were_written(tmp_path):
    """Names of words that mean something else stay text; a gap stays a gap."""
    asked = [
        make_verdict(requirement="nan", device="12", must_snap=True, N_first=0.333333),
        make_verdict(requirement="b", margin=0.5, end="stays", more={"t_closed": 2.5}),
        make_verdict(requirement="c", must_snap="any", must_survive=1.0),
    ]
    write_verdicts(asked, tmp_path / "requirements.csv", "uN*us/um")
    read = read_verdicts(tmp_path / "requirements.csv")
    closings = [each.more.get("t_closed") for each in read]
    np.testing.assert_equal(closings, [np.nan, 2.5, np.nan])
    assert ",C (uN us um-1)," in (tmp_path / "requirements.csv").read_text()
    for before, after in zip(asked, read, strict=True):
        np.testing.assert_equal(vars(replace(after, more={})), vars(replace(before, more={})))


def test_a_figure_has_room_for_each_row(tmp_path, monkeypatch):
    rows = [make_verdict(requirement=name) for name in ("drop", "hit", "drop")]
    write_verdicts(rows, path := tmp_path / "requirements.csv", "uN*us/um")
    saved = Mock(return_value=nullcontext(style.double_column(2.0)))
    monkeypatch.setattr(style, "saved", saved)
    application.draw({"requirements": {}}, "figures", {"requirements": path})
    stem, _, height = saved.call_args.args
    assert (stem, height) == ("figures/requirements", 1.2 + 2 * 0.32)


@pytest.mark.usefixtures("paper")
def test_margins_are_the_data_with_their_bars_by_slack_and_the_worst_corner_is_in_front():
    shock = {"direction": "-z", "must_survive": 0.999, "temperature": -40.0}
    shock |= {"end": "ends differ", "share_staying": 0.25}
    keys = "requirement", "margin", "margin_error", "verdict", "must_snap", "break_probability"
    rows = [dict(zip(keys, row, strict=True)) for row in CASES["margins"]]
    verdicts = [make_verdict(**shock, **row) for row in rows]
    drop, _, shelf = verdicts
    assert replace(drop, duration=6e5).shock == "half sine -z, 600 s"
    ax = drawn(figure.draw_margins, verdicts)
    points = [line.get_xydata()[0].tolist() for line in ax.lines if line.get_marker() in "oX"]
    edge = [ax.get_xlim()[1], 2.0]  # of a shock that nothing snaps, as it must
    assert points == [[0.9, 0.0], [1.25, 1.0], edge]  # by slack, the failed first
    bars = [bar.get_segments()[0][:, 0].tolist() for bar in artists(ax, LineCollection)]
    ends = [1.25 * (1 - 0.0125), 1.25 * (1 + 0.0125)]  # of 1/0.8, with the same relative error
    assert bars == [pytest.approx([0.88, 0.92]), pytest.approx(ends)]
    notes = [(" ".join(text.get_text().split()), text.xy) for text in ax.texts]
    words = "the beam breaks", "ends differ, 25 % of the runs stay", "snaps at no $N$ seen"
    assert notes == [(line, (1, place)) for place, line in enumerate(words)]
    ax.figure.draw_without_rendering()
    # No words lie over marks, bars and the line at 1.
    assert min(text.get_window_extent().x0 for text in ax.texts) > ax.bbox.x1
    verdicts.append(replace(shelf, margin=1.2, verdict="met"))
    verdicts.append(replace(drop, requirement="hit", must_snap="any", margin=1.1))
    ax = drawn(figure.draw_margins, verdicts)
    dots = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "."]
    assert [points for points in dots if points] == [[[1.2, 0.0]]]  # the one that fails is in front
    assert len(ax.get_yticklabels()) == 4
    assert legend_words(ax)[-2:] == ["another shock or temperature", figure.WRONG["label"]]


@pytest.mark.parametrize(("changes", "line"), CASES["worst"])
def test_the_last_line_has_the_threshold_that_is_furthest_on_the_wrong_side(changes, line):
    row = make_verdict(**{"N": 1000.0, "N_first": 1250.0, "margin": 1.25} | changes)
    assert worst([row])[1] == line


def test_the_last_line_has_the_corner_of_each_shock_in_which_the_beam_stays_least():
    keys = "requirement", "must_snap", "share_staying", "N", "end"
    rows = [dict(zip(keys, row, strict=True)) for row in CASES["restless"]]
    assert restless([make_verdict(**row) for row in rows]).split("; ") == CASES["stays_least"]
