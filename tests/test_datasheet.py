"""The data sheet says what the functions it asks say."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap import datasheet
from snapmap.motion.history import extremes_of
from snapmap.shocks import make_shocks
from snapmap.study import Study
from snapmap.thresholds.requirements import check
from snapmap.tolerances.samples import Tolerances


@pytest.fixture(scope="module")
def sheet(handout):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(datasheet, "DURATIONS", (0.5, 1.0))
        device = dataclasses.replace(handout, stop_away=6.0, stop_toward=40.0)
        study = Study(device=device, model={"name": "cosines", "cosines": 3})
        shocks = make_shocks("half sine")
        asked = [{"name": "drop", "shocks": shocks, "N": 500.0, "f0": 1000.0, "snaps": False}]
        verdicts = [one._asdict() for one in check(study, asked, [25.0])]
        under = dataclasses.replace(study, shocks=shocks)
        verdicts[0] |= extremes_of(under, 500.0, 1000.0, 25.0)._asdict()
        scatters = Tolerances({"thickness": 0.05}, samples=32)
        return datasheet.datasheet(study, [25.0], scatters, asked, verdicts), device


def row(sheet, name):
    line = next(line for line in sheet.splitlines() if line.startswith(f"| {name}"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_thresholds_are_those_of_threshold(sheet):
    text, device = sheet
    asked = {"f0": [1000.0], "C": [25.0], "pulse": "half sine", "model": "cosines", "cosines": 3}
    found = snapmap.threshold(device, **asked)
    value, error = row(text, "+z, 1 ms")[0].split(" ± ")
    assert float(value) == pytest.approx(found.N_first.item(), rel=1e-4)
    assert float(error.split(",")[0]) == pytest.approx(found.N_error.item(), rel=0.1)


def test_statics_spread_and_margins_are_there(sheet):
    text, device = sheet
    frequency = 1e3 * np.sqrt(device.spring / device.mass) / (2 * np.pi)
    assert row(text, "frequency of the mass")[0] == f"{frequency:.5g} kHz"
    share = float(text.split("devices as made")[1].split("+z, 1 ms | ")[1].split(" ")[0])
    assert share == pytest.approx(2.2 * 2.5, rel=0.5)  # 2.2 % of the threshold per % of thickness
    assert row(text, "drop, does not trip")[2] == "met"
    assert row(text, "way of the mass towards")[2] == "drop, C = 25"
