"""The data sheet says what its tables of results say, and what the device is."""

from dataclasses import replace

import numpy as np
import pytest

from snapmap.applications.datasheet.datasheet import datasheet
from snapmap.applications.electrode.closures import CLOSING
from snapmap.applications.histories.history import extremes_of
from snapmap.applications.requirements.check import check, judge
from snapmap.applications.tolerances.dataset import tolerances_of
from snapmap.device.samples import Tolerances
from snapmap.pulse.shocks import make_shocks
from snapmap.study.provenance import device_sections
from snapmap.study.study import Study
from snapmap.thresholds.slow import growth_rate


def row_of(text, name):
    line = next(line for line in text.splitlines() if line.startswith(f"| {name}"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_thresholds_and_shares_are_those_of_the_results(handout):
    stops = {"stop_away": 6.0, "stop_toward": 40.0, "contact_at": -5.0}
    device = replace(handout, strength=900.0, **stops)
    study, shocks = (
        Study(device=device, model={"name": "cosines", "cosines": 3}),
        make_shocks("half sine"),
    )
    required = [{"name": "drop", "shocks": shocks, "N": 500.0, "f0": 1000.0, "snaps": False}]
    (verdict,) = check(study, required, [25.0])
    moved = extremes_of(replace(study, shocks=shocks), 500.0, 1000.0, 25.0)
    verdict, survival = judge(verdict, device, moved.stress_max, 0.999)
    closing = {key: 2.0 + i for i, key in enumerate(CLOSING)}
    row = closing | verdict._asdict() | moved._asdict() | survival._asdict()
    scatters = Tolerances({"thickness": 0.05}, samples=32)
    made = tolerances_of(study, {"C": [25.0], "f0": [1000.0]}, scatters, required)
    sections = device_sections(device)["device"] | {"mass": "10 mg", "quality_factor": 94}
    how = {"made": made, "title": "Crash sensor, 2026", "damper": ("mN*s/m", 1000.0)}
    text = datasheet(study, [row], {"device": sections}, required, **how)

    shock, degrees, C, threshold, spread, margin, met, *strength = row_of(
        text, "drop, does not trip"
    )
    assert (shock, degrees, C, met) == ("half sine +z, 1 ms", "20", "0.025", "met")
    value, error = map(float, threshold.split(" ± "))
    assert value == pytest.approx(verdict.N_first, rel=1e-4)
    assert error == pytest.approx(verdict.N_error, rel=0.1)
    assert margin.startswith(f"{verdict.N_first / 500.0:.4g}")
    share, uncertain = float(spread.split()[1]), float(spread.split()[4])
    assert share == pytest.approx(2.2 * 2.5, rel=0.5)  # 2.2 % of the threshold per % of thickness
    assert uncertain == pytest.approx(share / np.sqrt(2 * 32), rel=0.1)
    assert float(strength[0]) == pytest.approx(900 / moved.stress_max, rel=1e-2)
    assert row_of(text, "meet all")[1] == f"{100 * made['yield'].item():.1f} %"
    where = "drop, half sine +z, C = 0.025, 20 degC"
    assert row_of(text, "travel of the mass towards")[2] == where
    frequency = 1e3 * np.sqrt(device.spring / device.mass) / (2 * np.pi)
    assert row_of(text, "frequency of the mass")[0] == f"{frequency:.5g} kHz"
    for name, cells in {
        "beam: thickness": [f"{device.beam.thickness!r} um"],
        "mass": ["10 mg"],
        "quality factor": ["94"],
        "first closure": ["2 us", "6 us", where],
        "openings": ["4", "8", where],
        "force on the electrode at -5 um": ["10.723 uN"],
        "slow shock that snaps it": ["above 936.78 for longer than a dwell time"],
        "dwell time at C = 0.025 mN*s/m": [f"{2 / growth_rate(device, 25.0):.4g} us"],
    }.items():
        assert row_of(text, name) == cells
    heads = "| C, mN*s/m |", "| meet all, at 20 degC |", "at rest at 20 degC"
    assert all(words in text for words in (*heads, "](figures/requirements.png)"))
