"""The script `run`, driven with a stand-in for Python that makes venvs and installs nothing."""

import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from small_studies import cases_of
from small_workflow import wait_for

ROOT = Path(__file__).resolve().parents[2]
MAKE_VENV, FAKE_PYTHON, FAKE_UV = cases_of(__file__).values()
LOCK = "locks/requirements.lock"


class Clone:
    """A copy of `run` with a lock of its own, and stand-ins for Python first on PATH."""

    def __init__(self, folder, tmp):
        self.folder, self.fakes = folder, tmp / "fakes"
        self.fakes.mkdir()
        (folder / "locks").mkdir(parents=True)
        shutil.copy(ROOT / "run", folder)
        (folder / LOCK).write_text("# nothing\n")
        for name in ("python3", *(f"python3.{minor}" for minor in range(11, 15))):
            self.fake(name, FAKE_PYTHON)
        self.change("pass")
        path = f"{self.fakes}:/usr/bin:/bin"
        self.environment = {"HOME": str(tmp / "home"), "TMPDIR": str(tmp), "PATH": path}

    def fake(self, name, text):
        known = f"#!/bin/sh\nfakes='{self.fakes}' python='{sys.executable}'\n{MAKE_VENV}"
        (self.fakes / name).write_text(known + text)
        (self.fakes / name).chmod(0o755)

    def change(self, python_code):
        (self.fakes / "change").write_text(python_code)

    def fault(self, shell_code):
        (self.fakes / "fault").write_text(shell_code)

    def start(self, *command, **options):
        options |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen([self.folder / "run", *command], env=self.environment, **options)

    def run(self, *command, input=None, **options):
        process = self.start(*command, stdin=subprocess.PIPE, **options)
        out, err = process.communicate(input, timeout=60)
        return subprocess.CompletedProcess(command, process.returncode, out, err)

    def venvs_made(self):
        return (self.fakes / "venvs").read_text().splitlines()


@pytest.fixture
def clone(tmp_path):
    return Clone(tmp_path / "clone", tmp_path)


def assert_in_cache(done, tmp_path):
    """A venv that cannot lie in the clone lies in the user's cache, and that is said."""
    assert done.stdout == f"{tmp_path}/home/.cache/snapmap/venv\n"
    assert done.stdout.strip() in done.stderr


def test_run_passes_on_folder_arguments_input_output_path_and_status(clone, tmp_path):
    elsewhere, link = tmp_path / "some where", tmp_path / "link"
    elsewhere.mkdir()
    link.symlink_to(clone.folder / "run")
    clone.fault("cat; echo noise")  # of the install, which has neither input nor output
    assert clone.run("cat", input="line\n").stdout == "line\n"
    words = ["a  b", "", "*", "$HOME", "--flag='x'"]
    script = "import os, sys; print(os.getcwd(), sys.argv[1:]); sys.exit(7)"
    done = clone.run("python", "-c", script, *words, cwd=elsewhere)
    assert (done.returncode, done.stdout) == (7, f"{elsewhere} {words}\n")
    clone.environment |= {"PYTHONPATH": str(tmp_path), "PYTHONHOME": str(tmp_path)}
    said = clone.run("printenv", "PYTHONPATH", "PYTHONHOME").stdout
    assert said == f"{clone.folder}/workflow/scripts\n"
    out = subprocess.check_output([link, "printenv", "VIRTUAL_ENV"], env=clone.environment)
    assert out.decode() == f"{clone.folder}/.venv\n"


def test_snakemake_gets_snakefile_and_profile_of_the_clone_before_all_other_words(clone):
    (clone.fakes / "snakemake").write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    (clone.fakes / "snakemake").chmod(0o755)
    said = clone.run("snakemake", "-n", "a  b").stdout.splitlines()
    profile = f"{clone.folder}/profiles/default/profile.yaml"
    snakefile = f"{clone.folder}/Snakefile"
    assert said == ["--snakefile", snakefile, "--workflow-profile", profile, "-n", "a  b"]
    assert clone.run("echo", "snakemake").stdout == "snakemake\n"


def test_snapmap_is_the_command_of_the_clone(clone, tmp_path):
    """It imports no module of the folder of a study."""
    command = clone.folder / "workflow/scripts/snapmap/workflow/command.py"
    command.parent.mkdir(parents=True)
    command.write_text("import json, sys; print(sys.argv[1:])")
    (tmp_path / "study").mkdir()
    for name in ("json.py", "snapmap.py"):
        (tmp_path / "study" / name).write_text("raise RuntimeError")
    done = clone.run("snapmap", "check", "a  b.yaml", cwd=tmp_path / "study")
    assert done.stdout == "['check', 'a  b.yaml']\n"


def test_a_linked_venv_is_used_if_whole_and_never_cleared(clone, tmp_path):
    clone.run("true")
    venv, clone.folder = clone.folder / ".venv", tmp_path / "other"
    shutil.copytree(venv.parent, clone.folder, ignore=shutil.ignore_patterns(".venv"))
    (clone.folder / ".venv").symlink_to(venv)
    assert clone.run("true").stderr == ""
    (clone.folder / LOCK).write_text("# another\n")
    said = clone.run("printenv", "VIRTUAL_ENV").stdout
    assert re.fullmatch(rf"{clone.folder}/\.venv-\d+\n", said) and (venv / "stamp").exists()


def test_run_installs_once_and_beside_after_lock_path_or_python_change(clone, tmp_path):
    """Jobs may run in what was there."""
    (line,) = clone.run("true").stderr.splitlines()
    assert clone.run("true").stderr == ""
    venv, moved = str(clone.folder / ".venv"), tmp_path / "moved"
    assert venv in line and clone.venvs_made() == [venv]
    (clone.folder / LOCK).write_text("# another\n")
    _, line = clone.run("true").stderr.splitlines()
    assert line == f"run: {venv} is not of this lock and folder; remove it if nothing runs in it"
    clone.folder = clone.folder.rename(moved)
    clone.run("true")
    (clone.fakes / "broken").touch()
    clone.run("true")
    (clone.fakes / "broken").unlink()
    made = clone.venvs_made()
    assert [name.rpartition("-")[0] for name in made[1:]] == [venv, *[f"{moved}/.venv"] * 2]
    assert len({*made}) == len(made) == len([*moved.glob(".venv*/stamp")])
    assert clone.run("printenv", "VIRTUAL_ENV").stdout.strip() in made[2:]


def test_what_anything_writes_installs_nothing_anew(clone):
    clone.run("true")
    for name in ("python3", "../clone/.venv/bin/python"):
        clone.fake(name, f"echo noise; echo noise >&2\n{FAKE_PYTHON}")
    clone.environment["LD_PRELOAD"] = "/nonexistent.so"
    assert "installing" not in clone.run("true").stderr
    del clone.environment["LD_PRELOAD"]
    assert clone.run("true").stderr == "noise\n" and len(clone.venvs_made()) == 1


def test_where_no_path_is_plain_one_line_says_so_before_an_install(tmp_path):
    """Nor is there a cache folder where HOME is unset; a plain clone needs none."""
    clone = Clone(tmp_path / "jane doe" / "clone", tmp_path)
    for home in ({"HOME": f"{tmp_path}/jane doe"}, {}):
        clone.environment = {"PATH": clone.environment["PATH"], **home}
        done = clone.run("true")
        (line,) = done.stderr.splitlines()
        assert done.returncode == 1 and "set XDG_CACHE_HOME to a folder whose path has no" in line
    assert not (clone.fakes / "venvs").exists()
    clone.environment["XDG_CACHE_HOME"] = str(tmp_path / "cache")
    said = clone.run("printenv", "VIRTUAL_ENV").stdout
    assert said == f"{tmp_path}/cache/snapmap/venv\n"
    clone.folder = clone.folder.rename(tmp_path / "plain")
    del clone.environment["XDG_CACHE_HOME"]
    assert clone.run("printenv", "VIRTUAL_ENV").stdout == f"{tmp_path}/plain/.venv\n"


@pytest.mark.parametrize("name", ["R&D", "it's (1)"])
def test_no_special_sign_is_in_the_path_of_the_venv(tmp_path, name):
    clone = Clone(tmp_path / name, tmp_path)
    assert_in_cache(clone.run("printenv", "VIRTUAL_ENV"), tmp_path)
    assert sorted(path.name for path in clone.folder.iterdir()) == ["locks", "run"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root can write to every folder")
def test_a_read_only_clone_is_left_alone(clone, tmp_path):
    clone.folder.chmod(0o555)
    done = clone.run("printenv", "VIRTUAL_ENV")
    clone.folder.chmod(0o755)
    assert_in_cache(done, tmp_path)


def test_a_failed_install_is_reported_and_begun_again(clone):
    clone.fault("exit 1")
    failed = clone.run("echo", "reached")
    assert failed.returncode != 0 and failed.stdout == ""
    assert "the install failed" in failed.stderr.splitlines()[-1]
    assert not (clone.folder / ".venv").exists()
    clone.fault("")
    assert clone.run("echo", "reached").stdout == "reached\n"


def test_a_killed_install_is_begun_again(clone):
    clone.fault("sleep 60")
    process = clone.start("true", start_new_session=True)
    assert wait_for(lambda: (clone.fakes / "venvs").exists() and clone.venvs_made())
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    clone.fault("")
    assert clone.run("echo", "reached").stdout == "reached\n"
    assert len(clone.venvs_made()) == 2


OLD, NEW = "sys.version_info = (3, 10, 9)", "sys.version_info = (3, 15, 0)"
NO_VENV = "sys.modules.update(ensurepip=None)"  # Debian without python3-venv
NEITHER = "sys.modules.update(ensurepip=None, pip=None)"


@pytest.mark.parametrize("change", [OLD, NO_VENV, NEITHER])
def test_a_fault_is_one_line(clone, change):
    runs = {"no command given": clone.run()}
    clone.change(change)
    clone.fake("uv", "echo no network >&2\nexit 1\n")
    runs["apt install python3-venv (Debian, Ubuntu)"] = clone.run("true")
    for words, done in runs.items():
        (line,) = done.stderr.splitlines()
        assert (done.returncode, done.stdout) == (1, "") and words in line


@pytest.mark.parametrize(("change", "name"), [(OLD, "found"), (NO_VENV, "found"), (NEITHER, "uv")])
def test_uv_makes_the_venv_where_no_python_can(clone, change, name):
    """One on PATH, or the one that pip brings."""
    clone.change(change)
    clone.fake(name, FAKE_UV)
    done = clone.run("echo", "reached")
    assert done.stdout == "reached\n" and "run: installing" in done.stderr
    assert clone.venvs_made() == [str(clone.folder / ".venv")]


def test_a_newer_python_than_was_tested_is_said_to_be_untested_and_taken(clone):
    clone.change(NEW)
    clone.fake("uv", "exit 1\n")
    done = clone.run("echo", "reached")
    assert done.stdout == "reached\n" and "is untested" in done.stderr.splitlines()[0]


@pytest.mark.parametrize("lock", sorted(path.name for path in (ROOT / "locks").glob("*.lock")))
def test_each_lock_holds_only_exact_versions_and_hashes(lock):
    text = (ROOT / "locks" / lock).read_text().replace("\\\n", " ")
    for line in text.splitlines():
        assert re.fullmatch(r"[a-z0-9-]+==\S+( ; [^:]+?)?\s+(--hash=sha256:[0-9a-f]{64}\s*)+", line)


def test_the_lock_names_every_dependency():
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text())
    project, test = pyproject["project"], pyproject["dependency-groups"]["test"]
    wanted = [*project["dependencies"], *sum(project["optional-dependencies"].values(), test)]
    names = {re.match(r"[a-z0-9-]+", package)[0] for package in wanted}
    locked = re.findall(r"^[a-z0-9-]+(?===)", (ROOT / LOCK).read_text(), re.M)
    assert names - {"snapmap"} <= {*locked}


@pytest.mark.long
def test_run_installs_from_nothing(tmp_path):
    folder, home = tmp_path / "my clone", tmp_path / "home"
    for made in (folder / "locks", home):
        made.mkdir(parents=True)
    for name in ("run", "pyproject.toml", LOCK):
        shutil.copy(ROOT / name, folder / name)
    environment = os.environ | {"HOME": str(home), "XDG_CACHE_HOME": ""}

    def run(*command):
        return subprocess.check_output([folder / "run", *command], env=environment, text=True)

    assert run("python", "-c", "import numba; print(numba.njit(lambda x: x + 1)(1))") == "2\n"
    assert re.fullmatch(r"9\.\d+\.\d+\n", run("snakemake", "--version"))
