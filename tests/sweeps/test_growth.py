"""A grid that grows: what is known is kept, and the cut leaves no trace in the results."""

import itertools

import numpy as np
import pytest
import yaml
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from small_studies import THREE_COSINES

from snapmap.config.study import load_config
from snapmap.solver.cells import to_cells
from snapmap.solver.cost import steps_and_seconds
from snapmap.solver.models import build_model
from snapmap.sweeps.collect import collect_slabs
from snapmap.sweeps.cube import sweep
from snapmap.sweeps.grid import follow_rows
from snapmap.sweeps.slabs import slab_name, write_slab
from snapmap.workflow.plan import JOB_SECONDS, make_plan

STUDY = THREE_COSINES + "sweep: {horizon: 200 us, until: snap}"


def study(N, f0, C=(25.0,), model="cosines"):
    """A study of values in multiples of g, Hz and uN us/um."""
    document = yaml.safe_load(STUDY)
    document["sweep"] |= {
        "N": [float(value) for value in N],
        "f0": [f"{value!r} Hz" for value in map(float, f0)],
        "C": [f"{value!r} uN*us/um" for value in map(float, C)],
    }
    if model == "auto":
        document["model"] = {"name": "auto"}
    return load_config(document)


def cut(whole):
    """The slabs of a study, as tuples of axes and values."""
    slabs = make_plan(whole.grid, whole.model, whole.settings).slabs
    return [tuple(slab.items()) for slab in slabs]


def seconds(slab):
    """The expected time of a slab."""
    slab = dict(slab)
    whole = study(slab["N"], slab["f0"])
    model = build_model(whole.device, **whole.model)
    f0, N = np.meshgrid(slab["f0"], slab["N"])
    cells = to_cells(whole.device, 0, N, f0, 1.0, whole.settings.horizon)
    return steps_and_seconds(model, cells, whole.settings)[1].sum()


def cells(slabs):
    return [cell for slab in slabs for cell in itertools.product(*(values for _, values in slab))]


WHOLE = {"N": np.linspace(600, 2400, 16), "f0": np.geomspace(300, 10e3, 16), "C": [25.0]}


@pytest.fixture(autouse=True)
def small_jobs(monkeypatch):
    """Make jobs so short that a plane of 256 cells falls into some twenty slabs."""
    plane = {"C": (25.0,), "f0": tuple(WHOLE["f0"]), "N": tuple(WHOLE["N"])}
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", seconds(plane) / 12)


def write_all(whole, folder, code=""):
    """Write all slabs that are not there; returns their files and how many cells were written."""
    slabs = cut(whole)
    paths = [folder / f"{slab_name(whole, dict(slab))}.nc" for slab in slabs]
    new = [(slab, path) for slab, path in zip(slabs, paths, strict=True) if not path.exists()]
    for slab, path in new:
        write_slab(whole, dict(slab), path, code)
    return paths, len(cells(slab for slab, _ in new))


def follow_counted(monkeypatch):
    """Count the cells that slabs follow from now on, in a list of their numbers."""
    followed = []

    def counted(model, rows, N, *others):
        followed.append(rows.f0.size * len(N))
        return follow_rows(model, rows, N, *others)

    monkeypatch.setattr("snapmap.sweeps.slabs.follow_rows", counted)
    return followed


amplitudes = st.lists(st.floats(0, 1e4), min_size=1, max_size=12, unique=True)
frequencies = st.lists(st.floats(50, 1e5), min_size=1, max_size=12, unique=True)


@settings(deadline=None, max_examples=20)
@given(N=amplitudes, f0=frequencies)
def test_every_cell_is_in_one_slab_that_is_no_longer_than_a_job(N, f0):
    try:
        whole = study(N, f0)
    except ValueError:
        reject()  # values closer than rounding
    slabs = cut(whole)
    expected = itertools.product(*whole.axes.values())
    assert sorted(cells(slabs)) == sorted(expected)
    for slab in slabs:
        assert seconds(slab) <= JOB_SECONDS * (1 + 1e-9) or len(cells([slab])) == 1


@pytest.mark.parametrize(
    ("grown", "model"),
    [("both", "cosines"), ("shrunk", "cosines"), ("f0", "auto"), ("N", "auto")],
)
def test_only_new_cells_are_followed(tmp_path, monkeypatch, grown, model):
    """The cube of a grid that grew is that of one sweep; refined, extended and thinned out.

    By `auto` a cell depends on its neighbours along N.
    """
    some = {"f0": WHOLE["f0"][4::2], "N": WHOLE["N"][:12:2], "C": [25.0]}
    first = {"f0": WHOLE | {"f0": some["f0"]}, "N": WHOLE | {"N": some["N"]}}
    first |= {"both": some, "shrunk": WHOLE}
    old, new = first[grown], some if grown == "shrunk" else WHOLE
    write_all(study(**old, model=model), tmp_path)
    followed = follow_counted(monkeypatch)
    whole = study(**new, model=model)
    paths, _ = write_all(whole, tmp_path)
    kept = len(set(old["f0"]) & set(new["f0"])) * len(set(old["N"]) & set(new["N"]))
    kept *= grown != "N"
    assert sum(followed) == len(new["f0"]) * len(new["N"]) - kept
    options = {"modes": 3} if model == "cosines" else {}
    in_one = sweep(whole.device, **new, model=model, horizon=200.0, until="snap", **options)
    cube = collect_slabs(paths, whole.axes, {})
    assert set(cube.variables) == set(in_one.variables)
    for key in in_one.variables:
        assert cube[key].values.tobytes() == in_one[key].values.tobytes(), key
    counts = [key for key in in_one.attrs if key.startswith(("cells_", "share_"))]
    assert [cube.attrs[key] for key in counts] == [in_one.attrs[key] for key in counts]


def test_slabs_of_other_code_and_broken_ones_are_not_used(tmp_path, monkeypatch):
    old, new = study(**{**WHOLE, "f0": WHOLE["f0"][::2]}), study(**WHOLE)
    paths, _ = write_all(old, tmp_path, "one")
    followed = follow_counted(monkeypatch)
    made, written = write_all(new, tmp_path, "another")
    assert sum(followed) == written > 0
    for path in set(made) - set(paths):
        path.unlink()
    for path in set(paths) - set(made):
        path.write_bytes(path.read_bytes()[:-1000])
    followed.clear()
    written = write_all(new, tmp_path, "one")[1]
    assert sum(followed) == written > 0
