"""Required shocks judged by all that is known, and what a change of the device would do."""

import re
from pathlib import Path

import pytest
import yaml

import snapmap
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


def test_a_hint_names_the_requirement_that_then_fails(handout):
    """What must trip just above a threshold that is to rise by a third contradicts that."""
    study = cheap_study()
    found = snapmap.threshold(handout, [1000.0], [25.0], study.model, horizon=300.0)
    first = found.N_first.item()
    handling = RequiredShock(SHOCK | {"name": "handling", "N": 1.3 * first, "snaps": False})
    launch = RequiredShock(SHOCK | {"name": "launch", "N": 1.05 * first, "snaps": True})
    needs = [handling, launch]
    verdicts = [verdict for need in needs for verdict, _ in need.check(study, [25.0])]
    assert [one.verdict for one in verdicts] == ["failed", "met"]
    wrong, _ = worst(verdicts)
    words = hint(study, needs, verdicts, wrong)
    assert re.fullmatch(r".*a beam \d+% thicker.* meets it, all else unchanged", words)
    changes = re.findall(r"a (?:mass|spring|beam) \d+% \w+", words)
    assert len(changes) > 1 and words.count(" (then launch fails)") == len(changes)
    alone = hint(study, [handling], verdicts[:1], wrong)
    assert "then" not in alone and all(change in alone for change in changes)
    assert hint(study, needs, verdicts, verdicts[1]) == ""


def test_a_hint_counts_at_every_damper(handout):
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
    assert words.count(" (then stays fails)") == len(re.findall(r"\d+%", words)) > 0


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
