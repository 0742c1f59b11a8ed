"""Files that a config names: what they hold decides, and what cannot be a file is refused."""

import hashlib
import os
import tracemalloc

import numpy as np
import pytest
import yaml
from small_studies import THREE_COSINES, cases_of, changed, faults
from small_workflow import snakemake

import snapmap
from snapmap.applications.calibration.shots import read_shots
from snapmap.applications.requirements import shocks_of
from snapmap.applications.whole import files_of, load_config, planned_study
from snapmap.config.points import read_points
from snapmap.config.yaml_file import read_document
from snapmap.files.named import hold_to_plan, plan_with
from snapmap.pulse.pulse import ACCELERATIONS, TIMES, read_pulse
from snapmap.pulse.shocks import make_shocks

CASES = cases_of(__file__)
DOCUMENT = yaml.safe_load(THREE_COSINES) | CASES["study"]


def write_record(path, power):
    """Half a millisecond of a half sine to some power."""
    times = np.linspace(0, 0.5, 51)
    write_table(path, "time (ms),acceleration (g)", times, np.sin(np.pi * times / 0.5) ** power)
    return path


def write_table(path, header, *columns):
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a study, its record and its points."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(DOCUMENT), encoding="utf-8")
    (tmp_path / "points.csv").write_text("N,f0\n1000,2000\n", encoding="utf-8")
    write_record(tmp_path / "shock.csv", 1)
    return tmp_path


def test_a_study_knows_its_files_by_what_they_hold(folder):
    x = np.linspace(0, 600, 50)
    write_table("shape.csv", "x (um),w (um)", x, 5 * (1 - np.cos(2 * np.pi * x / 600)))
    study = load_config(changed(DOCUMENT, device__beam__shape={"file": "shape.csv"}))
    hashes = {path.name: hashlib.sha256(path.read_bytes()) for path in folder.glob("*.csv")}
    assert study.files() == {name: held.hexdigest() for name, held in hashes.items()}
    for shocks in (study.shocks, shocks_of(study)[0].shocks):
        assert shocks.files == {"shock.csv": study.files()["shock.csv"]}


def test_a_record_has_the_name_of_its_file(folder):
    for name in ("Prüfung 3, 2026-11-23 (kanal_1.2)", "x" * 200):
        assert read_pulse(write_record(folder / f"{name}.csv", 1)).name == name


def test_a_record_acts_along_the_direction_that_is_written(folder):
    for direction in ("+z", "-z"):
        study = load_config(changed(DOCUMENT, pulse__direction=direction))
        assert [*study.shocks.directions] == [direction]


def test_an_edit_since_the_plan_is_refused(folder, monkeypatch):
    study = load_config(DOCUMENT)
    monkeypatch.setenv("SNAPMAP_PLANNED", "{}")
    hold_to_plan(files_of(study))
    plan_with(files_of(study))
    assert planned_study(DOCUMENT, threads=2).run.threads == 2
    write_record(folder / "shock.csv", 3)
    (folder / "points.csv").write_text("N,f0\n1000,2001\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"^shock\.csv: was edited after the run was planned"):
        planned_study(DOCUMENT, threads=1)
    with pytest.raises(ValueError, match=r"file: shock\.csv: was edited: its SHA-256 is not the"):
        make_shocks(study.shocks.values())
    with pytest.raises(ValueError, match=r"^points\.csv: was edited: its SHA-256 is not the exp"):
        read_points(*study.own_points)


def test_a_long_cell_of_a_table_is_quoted_in_part(folder):
    long = "x" * 1_000_000
    heads = f"N,{long}", f"N,duration ({long})", "N,f0"
    for head, cell in zip(heads, ("1", "1", long), strict=True):
        (folder / "points.csv").write_text(f"{head}\n1000,{cell}\n", encoding="utf-8")
        (line,) = faults(DOCUMENT)
        assert line.startswith("marks: points.csv: ") and "x..." in line


@pytest.mark.parametrize(("key", "value", "head", "cell"), CASES["heads"])
def test_a_table_has_the_unit_of_its_header(folder, key, value, head, cell):
    table = f"{head},{'f0' if key == 'N' else 'N'},tripped\n{cell},900,no\n"
    (folder / "shots.csv").write_text(table)
    assert read_shots("shots.csv")[key].tolist() == [pytest.approx(value, rel=1e-15)]
    (folder / "points.csv").write_text(table.replace("tripped", "snapped"))
    (point,) = read_points("points.csv")
    read = point.N if key == "N" else point.f0
    assert read == pytest.approx(1e6 / value if key == "duration" else value, rel=1e-15)


@pytest.mark.parametrize("unit", ACCELERATIONS)
@pytest.mark.parametrize("time", TIMES)
def test_a_record_has_the_units_of_its_header(folder, time, unit):
    """The peak is -50 m/s^2, after 2 ms of 4; its size counts."""
    scale = {"g": 1 / 9.80665}.get(unit, 1.0)
    t = np.array([0.0, 2.0, 4.0]) * {"s": 1e-3, "ms": 1.0}.get(time, 1e3)
    write_table("record.csv", f"t ({time}),a [{unit}]", t, scale * np.array([0.0, -50.0, 0.0]))
    pulse = read_pulse("record.csv")
    assert pulse.duration == pytest.approx(4000.0, rel=1e-14)
    assert pulse.peak == pytest.approx(50e-6, rel=1e-14)


def test_contents_decide_what_is_made_anew_and_dates_do_not(folder):
    inputs = load_config(DOCUMENT).inputs()
    os.utime(folder / "shock.csv", (0, 0))
    assert load_config(DOCUMENT).inputs() == inputs
    write_record(folder / "other.csv", 3).replace(folder / "shock.csv")
    assert load_config(DOCUMENT).inputs() != inputs


@pytest.mark.long
def test_contents_decide_what_runs_again_and_dates_do_not(root, folder):
    cube = "results/cube.nc"
    snakemake(root, ".", "mine.yaml", cube)
    os.utime(folder / "shock.csv")
    assert "Nothing to be done" in snakemake(root, ".", "mine.yaml", "--dry-run", cube)[1]
    other = write_record(folder / "other.csv", 3)
    os.utime(other, (0, 0))
    other.replace(folder / "shock.csv")
    assert "simulate_all  " in snakemake(root, ".", "mine.yaml", "--dry-run", cube)[1]


def test_ten_million_rows_are_refused_unread(tmp_path):
    with open(tmp_path / "points.csv", "wb") as file:
        file.truncate(100_000_000)
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"points\.csv: has 100 MB; write at most 10000 rows"):
        read_points(tmp_path / "points.csv")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10_000_000


def test_no_other_file_is_quoted(tmp_path):
    (tmp_path / "points.csv").write_text("root:x:0:0:secret,word\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"points\.csv: line 1: ") as fault:
        read_points(tmp_path / "points.csv")
    assert "secret" not in str(fault.value) and "word" not in str(fault.value)


def test_plain_numbers_are_read_as_they_are(tmp_path):
    (tmp_path / "plain.yaml").write_text("a: [0, -7, 0.5, +3, 1.5e+3, .5, 1e3]\n")
    assert read_document(tmp_path / "plain.yaml") == {"a": [0, -7, 0.5, 3, 1500.0, 0.5, "1e3"]}


@pytest.mark.parametrize("read", [read_points, snapmap.read_pulse, read_document])
def test_what_never_ends_is_refused(tmp_path, read):
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "device.csv").symlink_to("/dev/zero")
    for path in tmp_path.iterdir():
        with pytest.raises(ValueError, match=rf"{path.name}: is not a file"):
            read(path)
