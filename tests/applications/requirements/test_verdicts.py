"""Required shocks judged by all that is known, and what a change of the device would do."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib.collections import LineCollection
from small_results import artists, drawn

import snapmap
from snapmap.applications.requirements import figure as requirements
from snapmap.applications.requirements.check import worst
from snapmap.applications.requirements.corners import read_verdicts
from snapmap.applications.requirements.required import RequiredShock
from snapmap.applications.requirements.verdicts import hint, write_verdicts
from snapmap.config.study import load_config
from snapmap.pulse.shocks import make_shocks

CONFIG = Path(__file__).parents[3] / "config" / "config.yaml"
SHOCK = {"f0": 1000.0, "shocks": make_shocks(), "survives": 0.999}


def cheap_study():
    """The handout's device by three cosines, to 300 us after a shock."""
    document = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    document |= {"model": {"name": "cosines", "modes": 3}}
    document["sweep"]["horizon"] = "300 us"
    return load_config(document).of_thresholds()


def test_a_hint_names_the_requirement_that_then_fails_at_any_damper(handout):
    """What the first damper needs must not make another requirement fail at the second."""
    study = cheap_study()
    found = snapmap.threshold(handout, [1000.0], [25.0, 400.0], study.model, horizon=300.0)
    damped, light = found.N_first.values.ravel()[::-1]
    trips = RequiredShock(SHOCK | {"name": "trips", "N": 0.97 * damped, "snaps": True})
    stays = RequiredShock(SHOCK | {"name": "stays", "N": 0.97 * light, "snaps": False})
    needs = [trips, stays]
    verdicts = [one for need in needs for one, _ in need.check(study, [25.0, 400.0])]
    wrong, _ = worst(verdicts)
    assert (wrong.requirement, wrong.C) == ("trips", 400.0) and light < 0.95 * damped
    words = hint(study, needs, verdicts, wrong)
    assert re.fullmatch(r".*a beam \d+% thinner.* meets it, all else unchanged", words)
    changes = re.findall(r"a (?:mass|spring|beam) \d+% \w+", words)
    assert len(changes) > 1 and words.count(" (then stays fails)") == len(changes)
    alone = hint(study, [trips], verdicts[:2], wrong)
    assert "then" not in alone and all(change in alone for change in changes)
    assert hint(study, needs, verdicts, verdicts[0]) == ""


@pytest.mark.parametrize(("strength", "breaks"), [("1 MPa", True), ("100 GPa", False)])
def test_the_closing_line_says_where_the_beam_breaks(strength, breaks, tmp_path, capsys):
    """A shock far below the threshold fails by the strength alone, and the line says so."""
    document = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    document["device"]["strength"] = strength
    document["sweep"]["C"] = ["25 uN us/um"]
    needs = {"name": "handling", "N": 50, "f0": "1 kHz", "snaps": False, "survives": True}
    document["requirements"] = [needs]
    study = load_config(document)
    write_verdicts(study, study.requests["requirements"], str(tmp_path / "requirements.csv"))
    line = capsys.readouterr().out
    assert ("the beam breaks in handling" in line) == breaks == ("failed: handling" in line)


def test_names_of_verdicts_stay_text_and_numbers_are_numbers(tmp_path):
    path = tmp_path / "requirements.csv"
    head = "requirement,device,margin,must_snap,verdict,must_survive\n"
    path.write_text(f"{head}nan,12,nan,True,met,0.999\nb,,0.5,False,failed,nan\nc,,1,any,met,1\n")
    first, second, third = read_verdicts(path)
    assert third["must_snap"] == "any"
    assert (first["requirement"], first["device"], second["device"]) == ("nan", "12", "")
    assert first["margin"] != first["margin"] and second["margin"] == 0.5
    assert (first["must_snap"], second["must_snap"], first["verdict"]) == (True, False, "met")
    assert second["must_survive"] != second["must_survive"]


@pytest.mark.usefixtures("paper")
def test_margins_of_requirements_are_the_data_with_their_bars():
    verdicts = [
        {"requirement": "drop", "margin": 0.8, "margin_error": 0.01, "verdict": "met"},
        {"requirement": "back", "margin": np.nan, "margin_error": np.nan, "verdict": "met"},
        {"requirement": "shelf", "margin": 0.9, "margin_error": 0.02, "verdict": "failed"},
    ]
    for row, breaks, must in zip(verdicts, [0.0, 1e-4, 0.01], [True, False, False], strict=True):
        row |= {"device": "", "C": 25.0, "must_snap": must}
        row |= {"must_survive": 0.999, "break_probability": breaks, "start": "first"}
        row |= {"shape": "half sine", "direction": "-z", "temperature": -40.0}
    ax = drawn(requirements.draw_margins, verdicts)
    points = [line.get_xydata()[0].tolist() for line in ax.lines if line.get_marker() in "oX"]
    assert points == [[0.9, 0.0], [0.8, 1.0]]  # by slack, the failed first
    bars = [bar.get_segments()[0][:, 0].tolist() for bar in artists(ax, LineCollection)]
    assert bars == [pytest.approx([0.88, 0.92]), pytest.approx([0.79, 0.81])]
    assert [text.xy[1] for text in ax.texts] == [0, 2]  # breaks; no threshold
    any_way = verdicts[0] | {"must_snap": "any", "margin": 1.1}
    verdicts += [verdicts[2] | {"margin": 1.2, "verdict": "met"}, any_way | {"requirement": "hit"}]
    ax = drawn(requirements.draw_margins, verdicts)
    dots = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "."]
    assert [one for one in dots if one] == [[[1.2, 0.0]]]  # the corner that fails is in front
    assert len(ax.get_yticklabels()) == 4
