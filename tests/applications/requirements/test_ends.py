"""How the beam ends after a shock that must trip it: a switch that comes back meets nothing."""

import re

import numpy as np
import pytest
import yaml
from small_studies import THREE_COSINES, cases_of, changed
from varied import varied

import snapmap
from snapmap.applications.histories.history import NEAR
from snapmap.applications.page.figure import _worst
from snapmap.applications.requirements import application
from snapmap.applications.requirements.check import check
from snapmap.applications.requirements.verdict import read_verdicts
from snapmap.applications.whole import load_config
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.adaptive import choose_model
from snapmap.solver.outcome import side_at_end
from snapmap.study.axes import rows_of
from snapmap.study.shock import Shock
from snapmap.study.study import Study

F0, C, HORIZON = 8000.0, 25.0, 4000.0
ENDS = {0.03: "stays", 2e-3: "ends differ", 1e-4: "arrives and returns"}
"""How the beam of such damping, 1/us, ends at twice its threshold."""
VERDICTS = {"stays": "met", "ends differ": "unclear", "arrives and returns": "failed"}


def stiff(handout, damping):
    """A beam of rise 2.43 thicknesses, whose way back is short, as a study by three cosines."""
    device = varied(handout, thickness=3.0, rise=7.3, damping=damping)
    model = {"name": "cosines", "modes": 3}
    return Study(device, model=model, horizon=HORIZON)


def judged(study, *levels, f0=F0, snaps=True):
    """The verdicts on half sines of so many N."""
    shock = {"f0": f0, "snaps": snaps, "shocks": make_shocks("half sine")}
    return check(study, [Shock(name=f"{N:g}", N=N, **shock) for N in levels], [C], 1e-3)


@pytest.mark.parametrize("damping", ENDS)
def test_a_beam_that_must_trip_must_stay(handout, damping):
    """The ends are those of a sweep over the same N, in both of its steps."""
    study, N = stiff(handout, damping), 2320.0
    (verdict,) = judged(study, N)
    how = {"pulse": "half sine", "horizon": HORIZON}
    near = {"f0": [F0], "C": [C]}
    cube = snapmap.sweep(Study(study.device, study.model, **how), N * NEAR, **near).squeeze()
    assert cube.t_snap.notnull().all() and verdict.N_first < 0.55 * N
    stay = (cube.well == 2).values
    again = np.where(cube.well_reproduced == 1, stay, ~stay)
    assert verdict.share_staying == pytest.approx(np.mean([stay, again]))
    assert verdict.end == ENDS[damping] and verdict.verdict == VERDICTS[verdict.end]
    others = [judged(study, N, snaps=snaps)[0].verdict for snaps in ("arrives", False)]
    assert others == ["met", "failed"]


def test_just_above_its_threshold_a_damped_beam_meets_it_whatever_lies_below(handout):
    """Runs near N that do not arrive, being below the threshold, say nothing of the end."""
    study = stiff(handout, 0.03)
    first = judged(study, 2320.0)[0].N_first
    above, below = judged(study, 1.004 * first, 0.97 * first)
    assert (above.verdict, above.end, above.share_staying) == ("met", "stays", 1.0)
    assert (below.verdict, below.end) == ("failed", "does not arrive")


def test_no_shock_is_met_that_ends_elsewhere_in_finer_steps(handout):
    """A lightly damped beam over many N: some are met, and stay; of the others some return."""
    study, levels, f0 = stiff(handout, 2e-3), np.linspace(1450.0, 4500.0, 40), 2000.0
    met = np.array([verdict.verdict == "met" for verdict in judged(study, *levels, f0=f0)])
    grid, stays = study.set_out({"C": [C], "f0": [f0]}), []
    rows = rows_of(grid)._replace(pulses=make_shocks("half sine").pulses)
    cells = rows.cells(grid.device, levels, HORIZON).flat()
    for step in (0.6, 0.35, 0.25):
        model = choose_model(grid.device, study.model).with_step(step)
        stays.append(side_at_end(model.follow(cells, study.run), 1e-3) == 2)
    assert 20 < met.sum() < 40 and np.all(stays, axis=0)[met].all()
    assert not np.all(stays, axis=0)[~met].all()


BEAM = {"span": 600.0, "rise": 6.0, "thickness": 2.5, "depth": 20.0, "youngs_modulus": 169e3}
BEAM |= {"mass": 7.456e3, "spring": 1.5, "contact": np.inf, "gap": 2.0, "damping": 5.0005e-3}


def test_a_beam_that_stays_in_an_independent_code_is_said_to_stay(handout):
    """It stays there at all 21 N, by 12 and 18 cosines; in long steps and by three it returns."""
    device, f0, C = varied(handout, **BEAM), 1e6 / 300, 21.0
    study, levels = Study(device, pulse="half sine", horizon=4000.0), 3300.0 * NEAR
    cube = snapmap.sweep(study, levels, [f0], [C])
    assert (cube.well == 2).all() and cube.well_reproduced.mean() > 0.9
    shock = {"name": "trips", "N": 3300.0, "f0": f0, "snaps": True}
    shock["shocks"] = make_shocks("half sine")
    (verdict,) = check(study, [Shock(**shock)], [C], 1e-3)
    assert (verdict.verdict, verdict.share_staying) == ("met", 1.0)


def test_a_beam_that_is_pushed_back_must_stay_in_its_first_shape(handout):
    """A mass on a weak damper comes back, and strikes it down again; a strong damper holds it."""
    device, model = varied(handout, damping=0.03), {"name": "cosines", "modes": 3}
    study = Study(device, model, horizon=1000.0)
    shock = {"name": "reset", "f0": 2000.0, "snaps": True, "start": "second", "N": 60_000.0}
    shock["shocks"] = make_shocks("half sine", "-z")
    light, damped = check(study, [Shock(**shock)], [25.0, 3000.0], 1e-3)
    assert (light.end, light.verdict) == ("arrives and returns", "failed")
    assert (damped.end, damped.verdict) == ("stays", "met")


def test_the_last_line_the_table_and_the_page_tell_that_it_returns(tmp_path, capsys):
    document = changed(yaml.safe_load(THREE_COSINES), **cases_of(__file__))
    study, path = load_config(document), tmp_path / "requirements.csv"
    with pytest.warns(UserWarning, match="the mass travels") as warned:
        application.run(study, path)
    (line,) = [str(warning.message) for warning in warned if "travels" in str(warning.message)]
    rows = read_verdicts(path)
    assert application.counts(study) == {"verdicts": len(rows)} == {"verdicts": 4}
    far = [row.requirement for row in rows if row.travel_over_rise > 5]
    assert far and f" in {len(far)} of {len(rows)} rows, of {', '.join(dict.fromkeys(far))}" in line
    words = capsys.readouterr().out
    assert "failed: crash" in words and "arrives and returns" in words
    assert {row.must_snap for row in rows} == {True, "arrives"}
    least = min(row.share_staying for row in rows if row.requirement == "crash")
    assert re.match(r"failed: arrives and returns, at worst \(half sine", _worst("crash", rows))
    assert least == 0.0 and _worst("no such", rows) == ""
