"""A grid that grows: what is known is kept, and the cut leaves no trace in the results."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from small_results import assert_same_cube
from small_studies import THREE_COSINES, cases_of

import snapmap
from snapmap import Study
from snapmap.applications.whole import load_config
from snapmap.solver.cells import to_cells
from snapmap.solver.cost import steps_and_seconds
from snapmap.solver.models import build_model
from snapmap.sweeps.cube import collect_slabs
from snapmap.sweeps.slabs import follow_rows, slab_name, write_slab
from snapmap.workflow.plan import JOB_SECONDS, make_plan

CASES = cases_of(__file__)
STUDY = THREE_COSINES + "run: {horizon: 200 us, until: snap}"


def study(N, f0, C=(25.0,), model="cosines"):
    """A study of values in multiples of g, Hz and uN us/um."""
    document = yaml.safe_load(STUDY)
    document["sweep"] = {"N": [*map(float, N)], "f0": [f"{float(value)!r} Hz" for value in f0]}
    document["sweep"]["C"] = [f"{float(value)!r} uN*us/um" for value in C]
    if model == "auto":
        document["model"] = {"name": "auto"}
    return load_config(document)


def cut(whole):
    return make_plan(whole).slabs


def seconds(slab):
    """The expected time of a slab."""
    whole = study(slab["N"], slab["f0"])
    model = build_model(whole.device, whole.model)
    f0, N = np.meshgrid(slab["f0"], slab["N"])
    cells = to_cells(whole.device, 0, N, f0, 1.0, whole.run.horizon)
    return steps_and_seconds(model, cells, whole.run)[1].sum()


def cells_of(slabs):
    return [cell for slab in slabs for cell in itertools.product(*slab.values())]


WHOLE = {"N": np.linspace(600, 2400, 16), "f0": np.geomspace(300, 10e3, 16), "C": [25.0]}


@pytest.fixture(autouse=True)
def small_jobs(monkeypatch):
    """Make jobs so short that a plane of 256 cells falls into seven slabs."""
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", seconds(WHOLE) / 4)


def write_all(whole, folder, code=""):
    """Write all slabs that are not there; returns their files and how many cells were written."""
    slabs = cut(whole)
    paths = [folder / f"{slab_name(whole, slab)}.nc" for slab in slabs]
    new = [(slab, path) for slab, path in zip(slabs, paths, strict=True) if not path.exists()]
    for slab, path in new:
        write_slab(whole, slab, path, code)
    return paths, len(cells_of(slab for slab, _ in new))


@pytest.fixture
def followed(monkeypatch):
    """How many cells slabs follow, in a list of their numbers."""
    numbers = []

    def counted(model, rows, N, *others):
        numbers.append(rows.f0.size * len(N))
        return follow_rows(model, rows, N, *others)

    monkeypatch.setattr("snapmap.sweeps.slabs.follow_rows", counted)
    return numbers


amplitudes = st.lists(st.floats(0, 1e4), min_size=1, max_size=12, unique=True)
frequencies = st.lists(st.floats(50, 1e5), min_size=1, max_size=12, unique=True)


@settings(deadline=None, max_examples=20, derandomize=True, database=None)
@given(N=amplitudes, f0=frequencies)
def test_every_cell_is_in_one_slab_that_is_no_longer_than_a_job(N, f0):
    try:
        whole = study(N, f0)
    except ValueError:
        reject()  # values closer than rounding
    slabs = cut(whole)
    assert sorted(cells_of(slabs)) == sorted(itertools.product(*whole.axes.values()))
    for slab in slabs:
        assert seconds(slab) <= JOB_SECONDS * (1 + 1e-9) or len(cells_of([slab])) == 1


@pytest.mark.parametrize(
    ("grown", "model"), [("both", "cosines"), ("shrunk", "cosines"), ("f0", "auto"), ("N", "auto")]
)
def test_only_new_cells_are_followed(tmp_path, followed, grown, model):
    """The cube of a grid that grew is that of one sweep; refined, extended and thinned out.

    By `auto` a cell depends on its neighbours along N.
    """
    some = {"f0": WHOLE["f0"][4::2], "N": WHOLE["N"][:12:2], "C": [25.0]}
    part = some if grown in ("both", "shrunk") else WHOLE | {grown: some[grown]}
    old, new = (WHOLE, part) if grown == "shrunk" else (part, WHOLE)
    write_all(study(**old, model=model), tmp_path)
    followed.clear()
    whole = study(**new, model=model)
    paths, _ = write_all(whole, tmp_path)
    kept = len(set(old["f0"]) & set(new["f0"])) * len(set(old["N"]) & set(new["N"]))
    kept *= grown != "N"
    assert sum(followed) == len(new["f0"]) * len(new["N"]) - kept
    in_one = snapmap.sweep(Study(whole.device, whole.model, horizon=200.0, until="snap"), **new)
    assert_same_cube(collect_slabs(paths, whole.axes, {}), in_one)


def test_slabs_have_as_many_C_as_their_jobs_have_time_for(tmp_path, followed, monkeypatch):
    """A new C falls into a slab of several, of which it alone is followed."""
    small = {"f0": [500.0, 2000.0], "N": [700.0, 900.0, 1200.0]}
    C = np.geomspace(1, 200, 40)
    part, whole = study(**small, C=np.delete(C, 7)), study(**small, C=C)
    few = make_plan(whole).seconds / 8
    for name, most in {"FEW_SECONDS": few, "JOB_SECONDS": 10 * few, "SLAB_CELLS": 10_000}.items():
        monkeypatch.setattr(f"snapmap.workflow.plan.{name}", most)
    write_all(part, tmp_path)
    assert 8 <= len(cut(whole)) <= 20
    followed.clear()
    paths, _ = write_all(whole, tmp_path)
    assert sum(followed) == 2 * 3
    in_one = snapmap.sweep(part, **whole.axes)
    assert_same_cube(collect_slabs(paths, whole.axes, {}), in_one)


@pytest.mark.parametrize(("share", "pulse"), CASES["shares"])
def test_slabs_have_several_devices_shapes_and_directions(
    tmp_path, followed, monkeypatch, share, pulse
):
    """A named device that is new, or that has another value, is followed alone."""

    def named(**thickness):
        device = yaml.safe_load(THREE_COSINES)["device"]
        named = {
            name: device | {"beam": device["beam"] | {"thickness": f"{value} um"}}
            for name, value in thickness.items()
        }
        return load_config(CASES["study"] | {"devices": named, "pulse": pulse})

    thin, thick = named(zinc=1.9, tin=2.0, tin2=2.1), named(gold=2.05, zinc=1.8, tin=2.0, tin2=2.1)
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", 10.0)
    monkeypatch.setattr("snapmap.workflow.plan.FEW_SECONDS", make_plan(thin).seconds * share)
    write_all(thin, tmp_path)
    followed.clear()
    paths, _ = write_all(thick, tmp_path)
    assert sum(followed) == 2 * math.prod(thick.grid.shape[1:])
    assert len(paths) == 1 or share < 1
    in_one = snapmap.sweep(thick, **{key: thick.axes[key] for key in ("N", "f0", "C")})
    assert_same_cube(collect_slabs(paths, thick.axes, {}), in_one)


def test_a_slab_has_the_same_name_however_its_study_is_written(handout):
    slab = {"C": (25.0,), "f0": (1e3,), "N": (900.0,)}
    models = snapmap.Cosines(modes=3, cosines=9), snapmap.Cosines(cosines=9, modes=3)
    name, other = (slab_name(Study(handout, model), slab) for model in models)
    assert name == other and re.fullmatch("[0-9a-f]{12}_[0-9a-f]{12}", name)


@pytest.mark.parametrize(("value", "slabs"), CASES["added"])
def test_an_added_value_extends_or_splits_only_the_slab_in_which_it_falls(
    monkeypatch, value, slabs
):
    """Slabs of two cells at most, cut between octaves and their halves."""
    monkeypatch.setattr("snapmap.workflow.plan.SLAB_CELLS", 2)
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", 1e6)  # of two cells
    values = [*range(1, 9)]
    for asked, runs in (values, CASES["old"]), ([*values, value], slabs):
        assert [[*slab["N"]] for slab in cut(study(asked, [1000.0]))] == runs


def test_a_grid_is_refused_for_its_size_above_ten_thousand_million_cells(monkeypatch):
    """Or else for its time."""
    monkeypatch.setattr("snapmap.workflow.plan.MOST_SECONDS", 0.0)
    most = {"N": np.arange(1e6), "f0": np.arange(1e3, 1.1e4, 1e3), "C": np.arange(1e3)}
    one = study([1], [1000])
    grid = one.grid._replace(axes=one.grid.axes | most)
    with pytest.raises(ValueError, match=r"^sweep\.f0: up to "):
        make_plan(replace(one, grid=grid))
    grid.axes["N"] = np.arange(1e6 + 1)
    line = r"^sweep: 1e\+10 cells, more than 1e\+10; write fewer points$"
    with pytest.raises(ValueError, match=line):
        make_plan(replace(one, grid=grid))


def test_slabs_of_other_code_and_broken_ones_are_not_used(tmp_path, followed):
    old, new = study(**{**WHOLE, "f0": WHOLE["f0"][::2]}), study(**WHOLE)
    paths, written = write_all(old, tmp_path, "one")
    made, more = write_all(new, tmp_path, "another")
    assert sum(followed) == written + more and more > 0
    for path in set(made) - set(paths):
        path.unlink()
    for path in set(paths) - set(made):
        path.write_bytes(path.read_bytes()[:-1000])
    followed.clear()
    assert sum(followed) < write_all(new, tmp_path, "one")[1] == sum(followed)
