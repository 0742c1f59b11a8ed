"""The model `auto`: what it calls safe, against its own finest level over whole maps."""

import numpy as np
import pytest
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.solver.adaptive import DISPUTED, RUNGS, TOLERANCE, build_adaptive
from snapmap.solver.cells import to_cells
from snapmap.solver.outcome import SNAPPED
from snapmap.solver.settings import Run

CASES = cases_of(__file__)
SNAP = Run(horizon=1500.0, until="snap", repeat=False)


def own_map(device, C):
    """40 x 40 cells about the device's own threshold; the amplitudes from a coarse first look."""
    f0 = np.geomspace(400, 2e4, 40)
    scan = np.geomspace(20, 2e5, 200)
    cube = snapmap.sweep(Study(device, "cosines", until="snap"), scan, f0[::13], [C])
    first = cube.N.where(cube.t_snap.notnull()).min().item()
    F, N = np.meshgrid(f0, np.linspace(0.7, 2.5, 40) * first, indexing="ij")
    return to_cells(device, 0, N, F, C, SNAP.horizon)


@pytest.mark.parametrize(("values", "C"), CASES["safe"])
def test_safe_cells_agree_with_the_top_level(handout, values, C):
    device = varied(handout, **values)
    adaptive, cells = build_adaptive(device), own_map(device, C)
    seen = adaptive.follow(cells, SNAP)
    asked = (adaptive.check, "snap"), (adaptive.top, "edge")
    runs = (level.follow(cells, SNAP.but(until=until)) for level, until in asked)
    check, top = (np.isfinite(run.t_snap) for run in runs)
    wrong = np.isfinite(seen.t_snap) != top
    assert 0.1 < top.mean() < 0.9 and wrong[seen.agreed != DISPUTED].mean() <= 1e-3
    assert not wrong[seen.level == 1].any() and (seen.level == 1).mean() < 0.35
    np.testing.assert_array_equal(seen.agreed == DISPUTED, (seen.level == 1) & (check != top))


@pytest.mark.parametrize("until", ["snap", "settled"])
def test_labels_change_where_the_threshold_is(handout, until):
    """Of fast pulses; in the steps of other cells they change up to 0.5 % below."""
    edges = snapmap.threshold(handout, f0=[9858.0, 12617.0, 12750.0, 13167.0], C=[25.0])
    assert not edges.ragged.any()
    share = 1e-3 * np.arange(-10.5, 10)
    for f0, first in zip(edges.f0.values, edges.N_first.values.ravel(), strict=True):
        grid = first * (1 + share), [f0], [25.0]
        labels = snapmap.sweep(Study(handout, until=until, repeat=False), *grid).t_snap
        far = abs(share) > labels.label_distance
        np.testing.assert_array_equal(labels.notnull().values.ravel()[far], share[far] > 0)


@pytest.mark.parametrize(("values", "N", "f0", "C", "levels", "few", "many"), CASES["strikes"])
def test_every_level_follows_a_mass_that_strikes_fast(handout, values, N, f0, C, levels, few, many):
    """On the way back, where tension turns the fastest modes."""
    how = {"pulse": "half sine", "start": "second", "until": "snap", "horizon": 616.0}
    device, cells = varied(handout, **values), {"N": np.linspace(*N), "f0": [f0], "C": [C]}
    for model in ("auto", *({"name": "cosines", "modes": modes} for modes in levels)):
        cube = snapmap.sweep(Study(device, model, **how), **cells)
        assert few <= cube.t_snap.notnull().sum() <= many


def test_a_tolerance_sets_the_steps(handout):
    """Of second order: a hundredth of the error, a tenth of the step."""
    cells = to_cells(handout, 0, 900.0, [[1500.0]], 25.0, 300.0)
    default, strict = (
        [level.steps.of(cells, SNAP.question).item() for level in (auto.base, auto.check, auto.top)]
        for auto in (build_adaptive(handout), build_adaptive(handout, TOLERANCE / 100))
    )
    assert strict == pytest.approx([step / 10 for step in default])


def test_a_map_until_all_has_settled_snaps_where_and_when_a_map_to_the_snap_does(handout):
    """To the bit; and what snaps ends as the second level says of it."""
    device, f0, C = varied(handout, damping=4e-3), [800.0, 3000.0], [25.0]
    N = np.linspace(900.0, 2000.0, 23)
    studies = [Study(device, until=until, horizon=3000.0) for until in ("settled", "snap")]
    ended, to_snap = (snapmap.sweep(study, N, f0, C) for study in studies)
    np.testing.assert_array_equal(ended.t_snap, to_snap.t_snap)
    np.testing.assert_array_equal(ended.level, to_snap.level)
    snapped = ended.t_snap.notnull().values
    second = snapmap.sweep(Study(device, f"{RUNGS[1]} cosines", horizon=3000.0), N, f0, C)
    both = snapped & second.t_snap.notnull().values
    np.testing.assert_array_equal(ended.well.values[both], second.well.values[both])
    assert both.sum() > 20 and not snapped.all()


def test_auto_by_name_records_how_it_decided(handout):
    N = np.linspace(900, 1100, 41)
    how = {"horizon": 300.0}
    cell = {"N": N, "f0": [1500.0], "C": [0.025]}
    cube = snapmap.sweep(Study(handout, {"name": "auto", "tolerance": 1e-3}, **how), **cell)
    assert cube.level.flag_meanings == "base top"
    first = int(np.argmax(np.isfinite(cube.t_snap.values.ravel())))
    assert cube.level.values.ravel()[first - 1 : first + 1].tolist() == [1, 1]
    assert (cube.level == 0).sum() > 30 and cube.agreed.all()
    shuffled = snapmap.sweep(Study(handout, **how), **(cell | {"N": N[::-1]}))
    np.testing.assert_array_equal(shuffled.t_snap.values[..., ::-1], cube.t_snap.values)


def test_a_history_is_that_of_the_finest_level_and_as_a_sweep_says_of_its_cell(handout):
    """In shorter steps than those of the sweep, so the times of the snap differ a little."""
    shock = 1000.0, 1500.0, 0.025
    run = snapmap.simulate(Study(handout, horizon=100.0), *shock)
    finest = snapmap.simulate(Study(handout, f"{RUNGS[-1]} cosines", horizon=100.0), *shock)
    assert run.t_snap == finest.t_snap and run.time_step == finest.time_step
    cube = snapmap.sweep(Study(handout, horizon=100.0), *([value] for value in shock))
    assert run.outcome == SNAPPED
    assert run.t_snap.item() == pytest.approx(cube.t_snap.item(), rel=2e-3)
