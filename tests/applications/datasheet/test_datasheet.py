"""The data sheet says what its tables of results say, and what the device is."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from small_results import make_verdict
from small_studies import cases_of
from varied import alone, varied

from snapmap.applications.datasheet.datasheet import OF_LAWS, _at_rest, _cells, datasheet, of_batch
from snapmap.applications.electrode.closures import CLOSING
from snapmap.applications.histories.history import extremes_of, free_travel
from snapmap.applications.requirements.check import check, judge
from snapmap.applications.requirements.summary import with_shares
from snapmap.applications.requirements.verdict import at_corner
from snapmap.applications.tolerances.dataset import tolerances_of
from snapmap.device.samples import Scatter, Tolerances
from snapmap.pulse.pulse import make_pulse
from snapmap.pulse.shocks import make_shocks
from snapmap.study.provenance import config_hash, device_sections
from snapmap.study.shock import Shock
from snapmap.study.study import Study
from snapmap.thresholds.slow import departure_rate

CASES = cases_of(__file__)


def row_of(text, name):
    line = next(line for line in text.splitlines() if line.startswith(f"| {name}"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_thresholds_and_shares_are_those_of_the_results(handout):
    stops = {"stop_away": 6.0, "stop_toward": 40.0, "contact_at": -5.0}
    device = replace(handout, strength=900.0, **stops)
    study = Study(device=device, model={"name": "cosines", "cosines": 3})
    shocks = make_shocks("half sine")
    required = [Shock(name="drop", shocks=shocks, N=500.0, f0=1000.0, snaps=False)]
    (verdict,) = check(study, required, [25.0])
    moved = extremes_of(study.under(shocks), 500.0, 1000.0, 25.0)
    closing = {key: 2.0 + i for i, key in enumerate(CLOSING)}
    verdict = judge(replace(verdict, **moved._asdict(), more=closing), device, 0.999)
    scatters = Tolerances({"thickness": Scatter("normal", 0.05, False)}, samples=32)
    made = tolerances_of(study, {"C": [25.0], "f0": [1000.0]}, scatters, required)
    sections = device_sections(device)["device"] | {"mass": "10 mg", "quality_factor": 94}
    source = {"title": "Crash sensor, 2026", "device": sections}
    (verdict,) = with_shares([verdict], required, made)
    text = datasheet(study, [verdict], source, required, made, ("mN*s/m", 1000.0), ["a doubt"])

    cells = row_of(text, "drop, must not trip")
    met, share, shock, degrees, C, required, threshold, margin, end, *strength = cells
    assert (shock, degrees, C, required) == ("half sine +z, 1 ms", "20", "0.025", "500")
    assert (end, met, share) == ("does not arrive", verdict.verdict_text, verdict.share_text)
    assert met == "met by the nominal device" and share.startswith("100.0 % (9")
    value, error = map(float, threshold.split(" ± "))
    assert value == pytest.approx(verdict.N_first, rel=1e-4)
    assert error == pytest.approx(verdict.N_error, rel=0.1)
    assert margin.startswith(f"{verdict.N_first / 500.0:.4g}")
    assert float(strength[0]) == pytest.approx(900 / moved.stress_max, rel=1e-2)
    assert row_of(text, "0.025")[0] == f"{100 * made['yield'].item():.1f} %"
    assert "at 95 % confidence: takes 2995 devices.\n" in text and "Warning: a doubt\n" in text
    where = "drop, half sine +z, 1 ms, C = 0.025, 20 degC"
    assert row_of(text, "travel of the mass towards")[2] == where
    frequency = 1e3 * np.sqrt(device.spring / device.mass) / (2 * np.pi)
    assert row_of(text, "frequency of the mass")[0] == f"{frequency:.5g} kHz"
    dwell = f"{2 / departure_rate(device, 25.0):.4g} us, for shocks up to N = 974.63"
    assert row_of(text, "time that the slow shock must stay above it, C = 0.025 ") == [dwell]
    for name, cells in CASES["of device"].items():
        assert row_of(text, name) == cells, name
    heads = "| C, mN*s/m |", "that meet all, at 20 degC:", "at rest at 20 degC"
    assert all(words in text for words in (*heads, "](figures/requirements.png)"))
    assert "exact" not in text


def test_all_corners_stand_in_two_rows_of_their_requirement_and_what_made_them(handout):
    """The worst, then the ranges of the others; a mass that flies too far marks its row."""
    study = Study(device=handout, model={"name": "cosines", "cosines": 3})
    both = make_shocks("half sine", "both")
    record = make_shocks(replace(make_pulse("half sine"), peak=100 * handout.gravity))
    hit = Shock(name="hit", N=5000.0, f0=1000.0, snaps=False, shocks=both)
    required = [hit, replace(hit, name="bump", N=50.0, shocks=record)]
    rows = []
    for verdict in check(study, required, [25.0, 200.0], temperatures=[20.0, 80.0]):
        shaken = at_corner(study, hit, replace(verdict, shape="half sine"))
        moved = extremes_of(shaken, verdict.N, verdict.f0, verdict.C)
        travel = free_travel(handout, *moved[:2])
        moved_so = replace(verdict, **moved._asdict(), travel_over_rise=travel)
        rows.append(judge(moved_so, handout, 0.999))
    source = CASES["source"]
    text = datasheet(study, rows, source, required[:1])
    for name, count in (("hit", 8), ("bump", 4)):
        of_name = [row for row in rows if row.requirement == name]
        worst, *others = sorted(of_name, key=lambda row: -row.badness[2])
        first = row_of(text, f"{name}, must not trip")
        margin = float(first[7].split(" ± ")[0])
        assert len(others) == count - 1 and margin == pytest.approx(worst.margin, rel=1e-3)
        assert first[2] == worst.shock and ("not valid" in first[0]) == (worst.travel_over_rise > 5)
    lines = text.splitlines()
    folded = [row_of("\n".join(lines[i:]), f"its other cases, {n}") for i, n in ((0, 7), (0, 3))]
    assert [cells[3:5] for cells in folded] == [["20 to 80", "25 to 200"]] * 2
    ends = [float(end) for end in folded[0][7].split(" to ")]
    known = sorted(row.margin for row in rows if row.requirement == "hit")[1:]
    assert ends == pytest.approx([known[0], known[-1]], rel=1e-3)
    assert row_of(text, "bump")[5] == "50 (0.5 of the record)" and "record" not in folded[0][5]
    assert "anchors that turn" in text and lines[-1].count("|") == 4
    assert row_of(text, "SHA-256") == [f"{config_hash(source)}..."]
    assert config_hash(source) != config_hash(source | {"title": "another"})
    for name, value in CASES["rows"].items():
        assert row_of(text, name) == [value]
    assert datasheet(study, rows, source, required[:1]) == text


def test_levels_of_all_pulses_stand_on_the_sheet_or_some_evenly_chosen():
    """A level that is not known says how many devices it takes, or that some never snap."""
    dims, shape = ("shape", "direction", "C", "f0"), (2, 2, 1, 9)
    about = {"share": 0.9, "confidence": 0.95}
    high = np.full(shape, 1100.0)
    high[1, 1] = np.nan
    data = {"N_no_fire": np.full(shape, 900.0), "N_all_fire": high, "ragged": 0 * high}
    data = {key: (dims, values, about) for key, values in data.items()}
    axes = {"shape": ["half sine", "versed sine"], "direction": ["+z", "-z"], "C": [25.0]}
    axes |= {"f0": np.arange(1.0, 10.0) * 100, "sample": np.arange(30), "temperature": 85.0}
    made = xr.Dataset(data, axes)
    shocks = make_shocks(["half sine", "versed sine"], "both")
    words, levels = of_batch(made, shocks, "C, uN*us/um")
    assert "of 30 devices as made at 85 degC, at 95 % confidence (12 of 36 pulses):" in words
    assert row_of(levels, "half sine +z") == ["10", "25", "900", "1100"]
    assert row_of(levels, "versed sine -z")[-1] == "some devices never snap"
    alone = made.isel(shape=0, direction=1, drop=True).isel(sample=slice(29))
    _, levels = of_batch(alone, make_shocks("half sine", "-z"), "C, uN*us/um")
    assert row_of(levels, "half sine -z")[-1] == "1100" and "takes" not in levels
    (words,) = of_batch(made.isel(sample=slice(28)), shocks, "C")
    assert words.endswith("at 85 degC, at 95 % confidence: takes 29 devices.\n")


@pytest.mark.parametrize(("rows", "cells"), CASES["cells"])
def test_cells_of_a_requirement_are_its_words_and_numbers_with_their_errors(rows, cells):
    found = _cells([make_verdict(**CASES["row"] | row) for row in rows])
    assert found == cells


def test_forces_that_are_laws_are_not_known_at_rest(handout):
    """A law in place of the beam's force leaves the frequency of the mass alone."""
    laws = None, SimpleNamespace(force=None), SimpleNamespace(force="own")
    of_row = [make_verdict()], ("uN*us/um", 1.0)
    known, of_mass, of_beam = (dict(_at_rest(handout, law, *of_row)) for law in laws)
    *of_both, frequency, slow, time = known
    assert known.pop(time).endswith(" us, for shocks up to N = 974.63")
    assert of_mass == known | {slow: OF_LAWS}
    assert of_beam == of_mass | dict.fromkeys(of_both, OF_LAWS) and frequency in CASES["of device"]


def test_each_device_has_a_sheet_of_its_own_values_and_verdicts(handout):
    """One that returns by itself has no second shape; one without a mass has no blow."""
    devices = [varied(handout, free=1.0, imperfection=0.01), alone(handout)]
    devices = dict(zip(CASES["sheets"], devices, strict=True))
    study = Study(devices, model={"name": "cosines", "cosines": 3})
    source = {"title": "Two", "devices": {name: {"mass": f"of {name}"} for name in devices}}
    verdicts = [make_verdict(device=name, requirement=f"drop of {name}") for name in devices]
    _, *sheets = datasheet(study, verdicts, source).split("# Data sheet of Two of ")
    for (name, (rows, none)), sheet in zip(CASES["sheets"].items(), sheets, strict=True):
        assert sheet.startswith(f"{name}\n")
        for row, cells in rows.items():
            assert row_of(sheet, row)[: len(cells)] == cells
        assert not [words for words in none if words in sheet]
