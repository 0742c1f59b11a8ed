"""What goes wrong on real machines, done for real: nothing is lost, and nothing false is merged."""

import os
import shutil
import signal
import subprocess
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
import small_workflow
import xarray as xr
import yaml
from small_studies import THREE_COSINES, cases_of

import snapmap
from snapmap.applications.whole import load_config
from snapmap.workflow.made import HEAD, LIST

pytestmark = pytest.mark.long

CASES = cases_of(__file__)
STUDY = yaml.safe_load(THREE_COSINES) | CASES["study"]
OLD = "results/window.nc"


class Folder:
    """A folder with a study, and the one command that runs it."""

    def __init__(self, root, path):
        self.path, self.slabs, self.cube = path, path / "results/slabs", path / "results/cube.nc"
        (path / "mine.yaml").write_text(yaml.safe_dump(STUDY))
        self.command = ["snakemake", "--snakefile", root / "Snakefile", "--directory", path]
        self.command += ["--configfile", path / "mine.yaml", "--cores", "1", "results/cube.nc"]

    def start(self, **options):
        """Start the command in the background."""
        pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        return subprocess.Popen(self.command, **pipe, **options)

    def run(self, check=True):
        """Run the command to its end, well unless it is not checked; returns its output."""
        run = self.start()
        output = run.communicate()[0]
        assert (run.returncode == 0) == check, output
        return output

    def finished(self):
        """The finished slabs: when each was written."""
        return {path.name: path.stat().st_mtime_ns for path in self.slabs.glob("*.nc")}

    def assert_made(self, cube):
        """The cube has the bytes of another."""
        assert self.cube.read_bytes() == cube.read_bytes()


def jobs_of(run):
    """The processes that simulate slabs for a run."""
    jobs = []
    for child in psutil.Process(run.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            jobs += [child] * "".join(child.cmdline()[-1:]).endswith("jobs.py")
    return jobs


def wait_for(what, run):
    """What a function returns once that is true; the run must still be there."""
    answer = small_workflow.wait_for(lambda: run.poll() is not None or what(), 600)
    assert run.poll() is None, run.communicate()[0]
    return answer


def kill_at_once(processes):
    for process in processes:
        process.kill()
    psutil.wait_procs(processes)


@pytest.fixture
def folder(root, tmp_path):
    return Folder(root, tmp_path)


@pytest.fixture(scope="module")
def resumed(root, tmp_path_factory):
    """A run killed on its way, refused beside itself, and gone on with by the same command.

    As that asks for the cube alone, it leaves what an older config has asked for.
    """
    folder, seen = Folder(root, tmp_path_factory.mktemp("resumed")), set()
    old = folder.path / OLD
    old.parent.mkdir()
    old.write_text("an old line")
    (old.parent / LIST).write_text(f"{HEAD}\n{OLD}\n")
    run = folder.start()
    # With two jobs begun on one core, one is done and on Snakemake's record.
    wait_for(lambda: seen.update(jobs_of(run)) or len(seen) == 2, run)
    before = folder.finished()
    run.send_signal(signal.SIGSTOP)
    output = folder.run(check=False)
    assert f"{folder.path}: another run is at work in this folder" in output
    assert "Traceback" not in output
    stopped = psutil.Process(run.pid)
    kill_at_once([*stopped.children(recursive=True), stopped])
    run.communicate()
    (folder.slabs / "0123456789abcdef.nc.99.part").touch()
    output, after = folder.run(), folder.finished()
    assert "results/cube.nc: 4800 cells" in output and "an old line" not in output
    assert old.exists() and "results/threshold.nc" not in output
    assert len(before) == 1 and before.items() < after.items() and len(after) == 2
    return folder


def test_a_killed_run_loses_nothing(resumed):
    study = load_config(STUDY)
    asked = snapmap.Study(study.device, "3 cosines", horizon=320_000.0, until="snap")
    with xr.open_dataset(resumed.cube) as cube:
        xr.testing.assert_equal(cube, snapmap.sweep(asked, **study.axes))
    assert not list((resumed.path / "results").rglob("*.part"))


def test_a_killed_job_is_run_again(folder, resumed):
    run = folder.start()
    wait_for(folder.finished, run)
    kill_at_once(wait_for(lambda: jobs_of(run), run))
    output, _ = run.communicate()
    assert run.returncode == 0 and "Trying to restart job" in output, output
    folder.assert_made(resumed.cube)


@pytest.fixture
def listening():
    """Ctrl-C is heard, though a shell ignores it for what it runs in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_ends_a_run_in_one_line(folder, listening):
    run = folder.start(start_new_session=True)
    jobs = wait_for(lambda: jobs_of(run), run)
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does; the jobs have hardly begun to import
    output, _ = run.communicate(timeout=60)
    assert run.returncode == 1 and not psutil.wait_procs(jobs, timeout=20)[1]
    assert "Traceback" not in output and "Error" not in output
    assert output.count("interrupted: finished files are kept") == 1


def test_jobs_end_with_a_killed_run(folder):
    run = folder.start()
    jobs = wait_for(lambda: jobs_of(run), run)
    run.kill()
    assert not psutil.wait_procs(jobs, timeout=20)[1] and not folder.finished()


def test_a_broken_slab_is_named_and_made_again(folder, resumed):
    shutil.copytree(resumed.path, folder.path, dirs_exist_ok=True)
    broken = min(folder.slabs.glob("*.nc"))
    broken.write_bytes(broken.read_bytes()[:20000])
    output = folder.run()
    (line,) = [line for line in output.splitlines() if "to be made again" in line]
    assert line.startswith(f"results/slabs/{broken.name}: ") and line.endswith("(changed since)")
    folder.assert_made(resumed.cube)


def test_slabs_of_tomorrow_are_joined(folder, resumed):
    shutil.copytree(resumed.path, folder.path, dirs_exist_ok=True)
    for path in folder.slabs.glob("*.nc"):
        os.utime(path, (2e9, 2e9))  # in 2033
    folder.cube.unlink()
    output = folder.run()
    assert "Follow" not in output and "Join the slabs" in output
    folder.assert_made(resumed.cube)


def test_a_job_out_of_memory_is_reported_by_name(folder, resumed):
    run, starved = folder.start(), set()

    def starve():
        for job in set(jobs_of(run)) - starved:
            starved.add(job)
            job.rlimit(psutil.RLIMIT_AS, (2**28, 2**28))
        return run.poll() is not None

    assert small_workflow.wait_for(starve, 600)
    output, _ = run.communicate()
    assert run.returncode != 0 and not folder.finished()
    assert "Error in rule simulate_slab" in output and "output: results/slabs/" in output
    folder.run()
    folder.assert_made(resumed.cube)


def run_in_own_mounts(script, *arguments):
    """What a shell script says that may mount what it likes; skips where that is not permitted."""
    unshare = ["unshare", "--map-root-user", "--mount", "sh", "-euc"]
    if subprocess.run([*unshare, "mount -t tmpfs none /tmp"], capture_output=True).returncode:
        pytest.skip("mounts are not permitted here")
    command = [*unshare, script, "sh", *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.mark.parametrize("size", ["100k", "150k"])  # too small for the slabs, or for the cube
def test_a_full_disk_is_named_and_leaves_no_broken_file(folder, resumed, size):
    (folder.path / "results").mkdir()
    output = run_in_own_mounts(CASES["fill"], folder.path, size, *folder.command)
    full, *_ = [line for line in output.splitlines() if "not written" in line]
    assert "MB are free there" in full and full.startswith("results/")
    left = [Path(name) for name in (folder.path / "full.txt").read_text().split()]
    whole = {path for path in left if path.parent.name == "slabs" or path.name == LIST}
    assert all(path.suffix == ".log" for path in {*left} - whole)
    folder.cube = folder.path / "cube.nc"
    folder.assert_made(resumed.cube)


def test_the_clone_and_the_packages_may_be_read_only(root, folder, resumed):
    """Nor does a run that nothing disturbs give another cube than one that was killed."""
    places = [root, Path(psutil.__file__).parents[1], folder.path]
    run_in_own_mounts(CASES["lock"], *places, *folder.command)
    folder.assert_made(resumed.cube)
