"""Shocks of a config: shapes, records, directions; and those that must or must not trip."""

from dataclasses import replace

import numpy as np
import pytest

import snapmap
from snapmap.applications.requirements.check import check, judge, summary, worst
from snapmap.applications.requirements.corners import Verdict, corners
from snapmap.pulse.pulse import make_pulse
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.settings import Settings
from snapmap.study.study import Study

SETTINGS = Settings(horizon=300.0)


def test_verdicts_follow_from_the_threshold_of_the_required_pulse(handout):
    record = replace(make_pulse("half sine"), peak=100 * handout.gravity)  # of a record of 100 g
    found = snapmap.threshold(handout, [2000.0], [25.0], pulse=record, horizon=300.0)
    first, error = found.N_first.item(), found.N_error.item()
    assert found.scale_first.item() == pytest.approx(first / 100)
    near = {"at": first, "in the bar below": first - error / 2}
    amounts = {"below": 0.99 * first, **near, "above": 1.01 * first}
    pulse = {"shocks": make_shocks(record), "f0": 2000.0}
    asked = [
        {"name": f"{name} {must}", "N": N, "snaps": must, **pulse}
        for name, N in amounts.items()
        for must in (True, False)
    ]
    verdicts = check(Study(device=handout, settings=SETTINGS), asked, [25.0])
    expected = ["failed", "met", *["unclear"] * 4, "met", "failed"]
    assert [one.verdict for one in verdicts] == expected
    for one, N in zip(verdicts, np.repeat([*amounts.values()], 2), strict=True):
        assert one.N_first == first and one.N_error == error
        assert one.margin == pytest.approx(first / N)
        assert (one.scale, one.scale_first) == pytest.approx((N / 100, first / 100))
        assert one.duration == 0.5 and one.shape == "half sine" and one.direction == "+z"
    told = summary(verdicts)
    assert told.startswith("2 of 8 requirements met; failed: below True, above False; unclear: at")
    one, words = worst(verdicts)
    off = {one.requirement: abs(np.log(one.margin)) for one in verdicts if one.verdict == "failed"}
    assert off[one.requirement] == max(off.values())
    assert ("not sensitive enough, trips" if one.must_snap else "too sensitive, trips") in words


def test_a_requirement_counts_under_each_shock_at_each_temperature(handout):
    """The verdict is the worst one; a shock that may trip or not has none of the trip."""
    model = {"name": "cosines", "modes": 3}
    device = replace(handout, modulus_slope=-1e-3)
    asked = {"model": model, "pulse": ["half sine", "sawtooth"], "direction": "both"}
    degrees = [-40.0, 120.0]
    found = snapmap.threshold(
        device, [2000.0], [25.0], temperature=degrees, horizon=300.0, **asked
    ).N_first.squeeze(["C", "f0"])
    required = {"f0": 2000.0, "shocks": make_shocks(asked["pulse"], asked["direction"])}
    N = float(found.mean())
    required |= {"name": "launch", "N": N, "snaps": True}
    others = {"name": "set back", "N": N, "snaps": "any"}
    study = Study(device=device, model=model, settings=SETTINGS)
    verdicts = check(study, [required, required | others], [25.0], temperatures=degrees)
    launch, back = verdicts[:8], verdicts[8:]
    for one in launch:
        place = {key: getattr(one, key) for key in ("temperature", "shape", "direction")}
        assert one.N_first == pytest.approx(found.sel(place).item(), rel=1e-4)
        assert one.verdict == ("met" if found.sel(place).item() < N else "failed")
    assert len({(one.temperature, one.shape, one.direction) for one in launch}) == 8
    assert summary(launch) == "0 of 1 requirements met; failed: launch"
    last = launch[np.argmax([one.margin for one in launch])]
    one, words = worst(launch)
    assert one == last
    assert f"launch, {last.shape} {last.direction}, C = 25, {last.temperature:g} degC" in words
    ((front, *rest),) = corners([each._asdict() for each in launch])
    assert front["N_first"] == last.N_first and len(rest) == 7
    assert {one.verdict for one in back} == {"met"} and worst(back) == (None, "")


def test_a_requirement_fails_if_the_beam_breaks(handout):
    blank = dict.fromkeys(Verdict._fields) | {"verdict": "met"}
    told, brittle = Verdict(**blank), replace(handout, strength=1500.0)
    for stress, must, verdict in ((1499, 0.999, "met"), (1501, 0.999, "failed"), (1501, 0, "met")):
        found, survival = judge(told, brittle, float(stress), must)
        assert found.verdict == verdict
        assert survival == (must, pytest.approx(1500 / stress), float(stress > 1500))
    found, survival = judge(told, handout, 9e9, 0.999)
    assert found.verdict == "met" and np.isnan(survival.strength_margin)
    scattered = replace(brittle, strength_modulus=2.0, strength_threshold=1000.0)
    verdicts = [
        judge(told, scattered, stress, 0.9)[0].verdict for stress in (900.0, 1400.0, 1600.0)
    ]
    assert verdicts == ["met", "met", "failed"]  # exp(-(1400 - 1000)^2/1500^2) = 0.931
