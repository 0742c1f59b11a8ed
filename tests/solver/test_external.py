"""A solver of the user's own: how seldom it is asked, what is kept of it, and what bars cover."""

import re
import runpy

import flat
import numpy as np
import pytest

import snapmap
from snapmap.config.study import load_config
from snapmap.files import counting
from snapmap.solver import plain_loop
from snapmap.solver.ledger import CellRun
from snapmap.solver.models import build_model
from snapmap.solver.options import Reference
from snapmap.thresholds.surface import search_of
from snapmap.thresholds.survey import survey

STEP = 0.0276  # of the handout's device, us
MOST = 60
LOG = []  # of the solvers below: N of each run
EDGES = [900.0]  # at which their labels change
ERROR = [0.0]  # of these, relative, in the step STEP
LICENCE = [np.inf]  # number of runs that it allows


@pytest.fixture(autouse=True)
def anew(monkeypatch):
    LOG.clear()
    monkeypatch.setitem(globals(), "EDGES", [900.0])
    monkeypatch.setitem(globals(), "ERROR", [0.0])
    monkeypatch.setitem(globals(), "LICENCE", [np.inf])


def N_of(cell):
    return cell.amplitude / cell.device.gravity


def solver(cell, step):
    LOG.append(N_of(cell))
    edges = np.array(EDGES) * (1 + ERROR[0] * (step / STEP) ** 2)
    return 1.0 if np.searchsorted(edges, N_of(cell)) % 2 else None


def solver_of_many(cells, steps):
    LOG.append(len(cells))
    return [1.0 if N_of(cell) > 900 else None for cell in cells]


def limited(cell, step):
    if len(LOG) >= LICENCE[0]:
        raise RuntimeError("the licence has\nexpired")
    return solver(cell, step)


@pytest.mark.parametrize("N", [150.0, 310.0, 936.8, 3000.0])
@pytest.mark.parametrize("error", [0.0, 1e-3, 0.01, -0.01])
def test_a_clean_threshold_takes_few_runs_and_its_bar_covers_the_exact_one(handout, N, error):
    """Exact is what the label tends to with the step; all are far apart from the static one."""
    EDGES[:], ERROR[:] = [N], [error]
    for f0 in (300.0, 1500.0, 2e4):
        LOG.clear()
        edges = flat.threshold(handout, [f0], [25.0], solver).squeeze()
        assert len(LOG) <= MOST
        assert abs(edges.N_first - N * (1 + error)) <= 1e-4 * edges.N_first and not edges.ragged
        assert abs(edges.N_first - N) <= edges.N_error <= (3 * abs(error) + 1e-3) * edges.N_first


def test_a_coarse_tolerance_takes_fewer_runs(handout):
    runs = []
    for tolerance in (1e-4, 1e-2):
        LOG.clear()
        flat.threshold(handout, [1500.0], [25.0], solver, tolerance=tolerance)
        runs.append(len(LOG))
    assert runs[1] <= runs[0] - np.log2(100) + 1


def test_wide_islands_make_a_row_ragged_and_no_limit_is_sought(handout):
    EDGES[:] = 900.0, 1000.0, 1200.0
    edges = flat.threshold(handout, [1500.0], [25.0], solver).squeeze()
    assert edges.ragged == 1 and edges.islands == 1
    assert abs(edges.N_first - 900) <= edges.N_error <= 40
    assert edges.N_always == pytest.approx(1200.0, rel=0.011)
    for key in ("N_latched", "velocity_change", "N_static", "N_bound", "N_slow", "dwell"):
        assert np.isnan(edges[key]).all()
    assert "10.0% elsewhere" in edges.N_first.comment


@pytest.mark.parametrize(("fails", "status"), [((600, 650), 1), ((860, 920), 3)])
def test_where_runs_just_below_the_first_snap_fail_no_threshold_is_known(handout, fails, status):
    """The exact one is 900, which a bar around 920 would not cover."""

    def failing(cell, step):
        return np.inf if fails[0] < N_of(cell) < fails[1] else solver(cell, step)

    edges = flat.threshold(handout, [1500.0], [25.0], failing).squeeze()
    assert edges.status == status and not edges.ragged
    known = status == 1
    assert (abs(edges.N_first - 900) <= edges.N_error) == np.isfinite(edges.N_always) == known


@pytest.fixture(scope="module")
def plain(handout):
    """The plain loop of the handout's device, as if it were a solver of one's own."""
    built = build_model(handout, Reference())
    system, target = plain_loop.starting(built, "first"), built.snap_target("first")
    no_history = np.empty((0, 2 * system.load.size + 4))

    def plain(cell, step):
        LOG.append(N_of(cell))
        steps = int(np.ceil(cell.t_end / step))
        load = cell.pulse.curve, cell.amplitude, cell.f0, cell.damping
        t, error, _ = plain_loop.follow(system, CellRun(*load, target, step, steps, no_history))
        if error > 1e-3:
            return np.inf
        return None if np.isnan(t) else t

    return plain


ROWS = [(500.0, 25.0), (1500.0, 200.0), (3000.0, 1.0), (12e3, 30.0), (20e3, 1000.0)]


@pytest.mark.parametrize(
    ("f0", "C"), [*[pytest.param(*row, marks=pytest.mark.long) for row in ROWS], (23880.8, 1.568)]
)
def test_a_frugal_search_finds_what_a_thorough_one_does(handout, plain, f0, C):
    """The last row is ragged: an island lies 0.15 % below its clean edge."""
    study = snapmap.Study(handout, plain, run={"horizon": 300.0})
    search = search_of(study, study.set_out({"C": [C], "f0": [f0]}))
    few, runs = survey(search), len(LOG)
    many = survey(search._replace(models=search.models._replace(frugal=False)))
    assert abs(few.N_first - many.N_first) <= few.N_error
    assert runs <= MOST or few.ragged.all()
    assert not (few.ragged & ~many.ragged).any() and few.ragged.all() == (f0 == 23880.8)
    assert runs < 0.25 * (len(LOG) - runs)


def test_an_interrupted_run_keeps_what_it_knows_and_the_next_asks_for_the_rest(
    handout, tmp_path, caplog
):
    file, asked = tmp_path / "new" / "runs.csv", ([300.0, 1500.0], [25.0])
    kept = snapmap.reference(solver=limited, kept=str(file))
    LICENCE[0] = 25
    where = r".+test_external\.py, line \d+: limited at N = \d+\.\d+, f0 = \d+ Hz, C = 25 uN\*us/um"
    with pytest.raises(
        ValueError, match=rf"\Amodel\.laws: {where}: RuntimeError: the licence has expired\Z"
    ):
        flat.threshold(handout, *asked, kept)
    head, *lines = file.read_text().splitlines()
    assert head.startswith("N,f0 (Hz),C,step (us),t_snap (us),") and len(lines) == 25
    assert [float(line.split(",")[0]) for line in lines] == LOG
    with open(file, "a") as damaged:
        damaged.write("900.0,1000.0,25.0,0.02")
    LICENCE[0] = np.inf
    there = flat.threshold(handout, *asked, kept)
    assert "runs.csv: left out damaged lines, 1 in all" in caplog.text
    runs = len(LOG)
    LOG.clear()
    whole = flat.threshold(handout, *asked, solver)
    assert there.N_first.equals(whole.N_first) and len(LOG) == runs
    LOG.clear()
    assert flat.threshold(handout, *asked, kept).N_error.equals(whole.N_error) and not LOG
    flat.threshold(handout, [1501.0], [25.0], kept)  # another cell
    assert LOG
    LOG.clear()
    both = flat.threshold(handout, *asked, kept, spring=[5.5, 5.6])  # another device
    assert LOG and both.isel(spring=[1]).N_first.values == pytest.approx(whole.N_first.values[None])


def test_runs_are_kept_by_the_file_of_the_solver(handout, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = "def solver(cell, step): return 1.0 * {}"
    document = {"N": [900.0], "f0": [1e3], "C": [0.0]}
    for factor in (1, 2):
        (tmp_path / "mine.py").write_text(text.format(factor))
        made = snapmap.reference(solver=runpy.run_path("mine.py")["solver"], kept="runs.csv")
        assert flat.sweep(handout, *document.values(), made).t_snap == factor
    wrong = [lambda cell, step, at=LOG: made, re.compile, "".join]
    wrong[0] = (lambda made: lambda cell, step: made)(1.0)
    for each in (wrong[0], runpy.run_path("mine.py")["solver"].__get__):
        with pytest.raises(ValueError, match=r"kept: needs a solver that is a function of a file"):
            snapmap.reference(solver=each, kept="runs.csv")


def test_a_config_keeps_the_runs_in_results(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("def solver(cell, step): return 1.0")
    import yaml
    from small_studies import THREE_COSINES

    document = yaml.safe_load(THREE_COSINES) | {"model": {"name": "reference", "laws": "mine.py"}}
    document["sweep"] = {"N": [900], "f0": ["1 kHz"], "C": ["25 kg/s"], "horizon": "0 us"}
    study = load_config(document)
    assert study.model.laws.kept == "results/solver_runs.csv"


def test_a_solver_may_take_several_cells(handout):
    N, f0 = np.linspace(700, 1100, 30), [1e3, 2e3]
    asked = {"repeat": False, "until": "snap"}
    many = flat.sweep(handout, N, f0, [25.0], solver_of_many, **asked)
    assert LOG == [60]
    one = flat.sweep(handout, N, f0, [25.0], solver, **asked)
    assert one.outcome.equals(many.outcome)
    with pytest.raises(ValueError, match=r"<lambda> at N = .* and 59 other cells: returns 1 times"):
        flat.sweep(handout, N, f0, [25.0], lambda cells, steps: [1.0], **asked)


def test_each_run_of_a_solver_counts_at_once(handout, monkeypatch):
    seen = []
    monkeypatch.setattr(counting, "_listeners", [lambda cells: seen.append((cells, len(LOG)))])
    flat.sweep(handout, [800.0, 900.0, 1000.0], [1e3], [25.0], solver, until="snap")
    assert seen == [(1, 1), (1, 2), (1, 3)]


@pytest.mark.long
def test_the_example_has_a_threshold_of_few_runs(root, handout):
    """A mass on its spring under a pulse of two of its periods, as in test_laws."""
    drop, runs = runpy.run_path(root / "examples" / "scipy_model.py")["solver"], []

    def counted(cell, step):
        runs.append(step)
        return drop(cell, step)

    f0 = np.sqrt(handout.spring / handout.mass) / (4e-6 * np.pi)
    x = np.linspace(0, 2 * np.pi, 100_001)
    falls = np.max((1 - np.cos(2 * x)) / 2 - 2 / 3 * (np.cos(x) - np.cos(2 * x)))
    N = 20 * handout.spring / (falls * handout.mass * handout.gravity)
    edges = flat.threshold(handout, [f0], [0.0], counted, horizon=0.0)
    assert abs(edges.N_first - N) <= edges.N_error and len(runs) <= MOST
