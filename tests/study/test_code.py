"""The hash of the code is of two parts: what makes numbers, and what draws."""

import re
from hashlib import sha256

import pytest

from snapmap.study import provenance
from snapmap.study.provenance import DRAWS, NUMBERS, code_hash, config_hash


def test_every_rule_names_the_code_that_it_runs(workflow_text):
    rules = re.split(r"^ *rule\b", workflow_text, flags=re.M)[1:]
    ran = [re.search(r"scripts/(\w+)\.py", rule) for rule in rules]
    named = [re.search(r"code=(\w+)", rule) for rule in rules]
    pairs = {(run[1], code[1]) for run, code in zip(ran, named, strict=True) if run}
    assert pairs == {("jobs", "numbers"), ("draw", "drawing")}


def test_the_parts_are_the_package_without_its_command():
    numbers, draws = ({path.name for path in paths} for paths in (NUMBERS, DRAWS))
    assert {"step.py", "quantities.py", "dataset.py"} <= numbers
    assert {"maps.py", "figure.py", "explore.js", "paper.mplstyle"} <= draws
    assert not numbers & {"maps.py", "figure.py", "explore.js", "command.py", "Snakefile"}


def test_an_edit_a_name_and_another_file_change_the_hash(tmp_path):
    (tmp_path / "inner").mkdir()
    made, edits = [], (("a.py", "1"), ("a.py", "2"), ("inner/b.js", "2"), ("notes.txt", "3"))
    for name, text in edits:
        (tmp_path / name).write_text(text)
        made.append(code_hash(tmp_path))
    assert len(set(made)) == 3 and made[2] == made[3]
    plain = made[0], config_hash({"b": 1, "a": 2})
    texts = b"a.py\x001", b'{"a": 2, "b": 1}'
    assert plain == tuple(sha256(text).hexdigest()[:12] for text in texts)
    (tmp_path / "0").mkdir()
    (tmp_path / "inner" / "b.js").rename(tmp_path / "0" / "b.js")
    assert code_hash(tmp_path) == made[3], "where a file lies is no part of it"
    (tmp_path / "a.py").rename(tmp_path / "c.py")
    assert code_hash(tmp_path) not in made


@pytest.mark.parametrize("changed", ["numpy", "numba", "scipy", "matplotlib", "plotly", "python"])
def test_other_packages_are_other_code(changed, monkeypatch):
    def hashes():
        provenance._packages.cache_clear()
        made = (provenance.hash_numbers, provenance.hash_drawing)
        return [[*hash_with(__file__).values()] for hash_with in made]

    before, found = hashes(), provenance.version
    assert all(re.fullmatch("[0-9a-f]{12}", digits) for (digits,) in before)
    if changed == "python":
        monkeypatch.setattr("platform.python_version", lambda: "3.99.0")
    version = lambda name: "99" if name == changed else found(name)  # noqa: E731
    monkeypatch.setattr(provenance, "version", version)
    numbers, drawing = (now != then for now, then in zip(hashes(), before, strict=True))
    provenance._packages.cache_clear()
    assert numbers != drawing and drawing == (changed in ("matplotlib", "plotly"))


def test_another_users_clone_keeps_its_commit(root, monkeypatch):
    asked = "describe", "--always", "--abbrev=7"
    commit = provenance._git(*asked)
    assert bool(commit) == (root / ".git").exists()
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    assert provenance._git(*asked) == commit
