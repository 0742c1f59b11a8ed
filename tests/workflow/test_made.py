"""The list of what runs have made: nothing leaves that is not on it."""

import os
import time
from pathlib import Path

import pytest

from snapmap.workflow import made
from snapmap.workflow.made import HEAD, LIST, begin_list, list_made, remove_others


@pytest.fixture(autouse=True)
def results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = Path("results")
    (folder / "figures").mkdir(parents=True)
    return folder


def make(*names):
    for name in names:
        Path(name).write_text("made")
    begin_list()
    list_made(names, "abc")


def test_what_is_made_and_not_kept_leaves_and_nothing_else(results):
    make("results/cube.nc", "results/figures/map.png")
    make("results/window.nc", "results/figures/window.png")
    users = [results / "figures" / "window_final.png", results / "measured.csv"]
    for path in users:
        path.write_text("mine")
    kept = {"results/cube.nc", "results/figures/map.png", "results/figures/new.png"}
    (line,) = remove_others(kept)
    names, _, words = line.partition(": ")
    assert names.split(", ") == ["results/figures/window.png", "results/window.nc"]
    assert words == "removed, as the config no longer asks for them"
    assert not any(Path(name).exists() for name in names.split(", "))
    assert all(path.read_text() == "mine" for path in users)
    (results / "window.nc").write_text("mine")  # it was the pipeline's, and is so no longer
    assert remove_others(kept) == []
    assert (results / "window.nc").read_text() == "mine"
    listed = (results / LIST).read_text().splitlines()[1:]
    assert [line.partition("\t")[0] for line in listed] == sorted(kept)[:2]


def test_what_is_not_as_a_plan_makes_it_is_told_with_the_reason(results):
    names = old, edited, right, foreign = [f"results/{name}.nc" for name in "abcd"]
    make(old, edited, right)
    for name in (edited, foreign):
        Path(name).write_text("mine")
    plan = dict.fromkeys([*names, "results/none.nc"], "abc") | {old: "other"}
    assert made.find_others(plan) == [old, edited, foreign]
    words = "to be made again, as not of this study and code"
    reasons = "made for another config or by other code", "changed since"
    reasons += ("unknown to results/made.txt",)
    for others, why in zip(([old], [old, edited], [old, edited, foreign]), reasons, strict=True):
        assert made.say_why(others) == f"{', '.join(others)}: {words} ({why})"
    made.hold_to_list([old, right, foreign])
    with pytest.raises(ValueError, match=r"^results/b\.nc: has changed since it was made; run"):
        made.hold_to_list(names)


def test_what_a_file_is_made_from_is_no_younger(results):
    make("results/a", "results/b", "results/c")
    now = time.time_ns()
    for name, at in (("a", -1), ("b", -2), ("c", 1000)):
        os.utime(f"results/{name}", ns=(now, now + at * 10**9))
    made.mend_times({"results/a": (), "results/b": ["results/a"], "results/c": ["results/b"]})
    a, b, c = (os.stat(f"results/{name}").st_mtime_ns for name in "abc")
    assert a == b == now - 2 * 10**9 and now <= c <= time.time_ns()


def test_many_are_named_in_one_line():
    make(*(f"results/figures/map_{number}.png" for number in range(9)))
    (line,) = remove_others(())
    assert line.count("results/") == 4 and ", 5 others: removed" in line
    make(*(f"results/figures/map_{number}.png" for number in range(4)))
    assert "others" not in remove_others(())[0]


def test_without_a_list_nothing_leaves(results):
    (results / "cube.nc").write_text("of an older version")
    assert remove_others(()) == []
    assert (results / "cube.nc").exists() and not (results / LIST).exists()


FOREIGN = (
    b"a list of the users\nresults/cube.nc\nmine.txt",
    f"{HEAD}\nmine.txt\nresults/../mine.txt\n{{}}/mine.txt\nresults\nresults/{LIST}\n\0".encode(),
    b"\xff\xfe",
)


@pytest.mark.parametrize("text", FOREIGN)
def test_a_foreign_list_removes_nothing(results, tmp_path, text):
    for path in (results / "cube.nc", Path("mine.txt")):
        path.write_text("mine")
    (results / LIST).write_bytes(text.replace(b"{}", str(tmp_path).encode()))
    remove_others(())
    assert (results / "cube.nc").exists() and Path("mine.txt").exists()


def test_no_link_leads_a_list_out_of_its_folder(results, tmp_path):
    (elsewhere := tmp_path / "elsewhere").mkdir()
    for path in (elsewhere / "secret", elsewhere / "linked", results / "a\x1b[31m"):
        path.write_text("mine")
    (results / "out").symlink_to("../elsewhere")
    (results / "back").symlink_to("out")
    (results / "loop").symlink_to("loop")
    (results / "old.nc").symlink_to(elsewhere / "linked")
    names = "out/secret", "back/secret", "out/../out/linked", "loop/a", "a\x1b[31m", "old.nc"
    lines = "\n".join(f"results/{name}" for name in names)
    (results / "made.txt").write_text(f"{HEAD}\n{lines}\n")
    (line,) = remove_others(())
    assert line.startswith("results/old.nc: removed")
    left = {path.name for path in elsewhere.iterdir()}
    assert left == {"secret", "linked"} and (results / "a\x1b[31m").exists()


def test_a_folder_of_results_may_be_a_link_itself(results, tmp_path):
    results.rename(scratch := tmp_path / "scratch")
    results.symlink_to(scratch)
    make("results/figures/window.png")
    remove_others(())
    assert not (scratch / "figures" / "window.png").exists()


def test_what_cannot_be_removed_is_named_and_stays_listed(results):
    make("results/window.nc")
    (results / "window.nc").unlink()
    (results / "window.nc").mkdir()
    line = "results/window.nc: from an older config, and cannot be removed"
    assert [remove_others(()) for _ in range(2)] == [[line]] * 2


def test_a_list_that_cannot_be_written_ends_no_run(results):
    (results / LIST).mkdir()
    make("results/cube.nc")
    assert remove_others(()) == [] and (results / "cube.nc").exists()
