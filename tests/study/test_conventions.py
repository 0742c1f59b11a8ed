"""The files keep the CF conventions, as the checker of the community sees them."""

import json

import pytest
import xarray as xr

import snapmap
from snapmap import Study
from snapmap.solver.outcome import ABSENT, OUTCOMES
from snapmap.study.variables import write

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the checker itself
MODEL = {"model": "3 cosines"}
# The checker takes what is called time for a date; the time of a history is a duration.
DURATION = "Coordinate variable 'time' should have standard_name='time', found: 'None'"


@pytest.fixture(scope="module")
def files(handout, tmp_path_factory):
    """A cube, a history and thresholds as files."""
    folder = tmp_path_factory.mktemp("files")
    made = {
        "cube": snapmap.sweep(Study(handout, **MODEL), [900.0, 1100.0], [1500.0, 3e3], [0.025]),
        "history": snapmap.simulate(Study(handout, horizon=100.0, **MODEL), 1000.0, 1500.0, 0.025),
        "threshold": snapmap.threshold(Study(handout, horizon=300.0, **MODEL), [1500.0], [0.025]),
    }
    for name, dataset in made.items():
        write(dataset, folder / f"{name}.nc")
    return folder


def complaints(path, checker):
    """Faults of high and medium priority in a file."""
    reason = "packages of locks/requirements-docs.lock are missing"
    runner = pytest.importorskip("compliance_checker.runner", reason=reason)
    runner.CheckSuite.load_all_available_checkers()
    report = path.with_suffix(".json")
    options = {"output_filename": str(report), "output_format": "json"}
    runner.ComplianceChecker.run_checker(str(path), [checker], 0, "normal", **options)
    result = json.loads(report.read_text())
    result = result.get(checker, result)
    checks = result["high_priorities"] + result["medium_priorities"]
    return {message for check in checks for message in check["msgs"]}


@pytest.mark.parametrize("name", ["cube", "history", "threshold"])
def test_files_keep_the_conventions_and_say_what_they_are(files, name):
    allowed = {DURATION} if name == "history" else set()
    assert complaints(files / f"{name}.nc", "cf:1.11") <= allowed
    missing = {message.split()[0] for message in complaints(files / f"{name}.nc", "acdd")}
    assert not missing & {"title", "summary", "keywords", "Conventions", "source", "history"}


def test_numbers_of_a_history_and_of_statics_are_variables_with_units(handout, files):
    with xr.open_dataset(files / "history.nc") as run:
        single = {key for key in run if not run[key].dims}
        assert {"outcome", "t_snap", "stress_max", "barrier", "work_error"} <= single
        assert run.outcome.attrs["flag_meanings"].split() == list(OUTCOMES[:ABSENT])
        for made in (run, snapmap.statics(handout)):
            assert all("units" in made[key].attrs for key in {*made} - {"outcome"})
            assert all(isinstance(value, str) for value in made.attrs.values())
