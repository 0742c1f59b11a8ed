"""What goes wrong on real machines, done for real: nothing is lost, and nothing false is merged."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
import xarray as xr
import yaml
from numba import njit
from small_studies import THREE_COSINES

import snapmap
from snapmap.config.study import load_config
from snapmap.numerics.kernels import compiled
from snapmap.sweeps.collect import collect_slabs
from snapmap.sweeps.plan import make_plan
from snapmap.sweeps.slabs import slab_name

STUDY = (
    THREE_COSINES
    + """sweep:
  N: {from: 600, to: 2400, points: 40}
  f0: {from: 300 Hz, to: 10 kHz, points: 20, spacing: log}
  C: [0.025 uN*us/um, 25 uN*us/um, 50 uN*us/um]
  horizon: 40 ms
  until: snap
"""
)
IN_OWN_MOUNTS = ["unshare", "--map-root-user", "--mount", "sh", "-euc"]


class Folder:
    """A folder with a study, and the one command that runs it."""

    def __init__(self, root, path):
        self.path, self.slabs, self.cube = path, path / "results/slabs", path / "results/cube.nc"
        (path / "mine.yaml").write_text(STUDY)
        self.command = ["snakemake", "--snakefile", root / "Snakefile", "--directory", path]
        self.command += ["--configfile", path / "mine.yaml", "--cores", "2", "results/cube.nc"]

    def start(self, **options):
        """Start the command in the background."""
        pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        return subprocess.Popen(self.command, **pipe, **options)

    def run(self):
        """Run the command to its end; returns its exit code and output."""
        run = self.start()
        return (run.communicate()[0], run.returncode)[::-1]

    def finished(self):
        """The finished slabs: when each was written."""
        return {path.name: path.stat().st_mtime_ns for path in self.slabs.glob("*.nc")}


def jobs_of(run):
    """The processes that simulate slabs for a run."""
    found = []
    for child in psutil.Process(run.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            found += [child] * "".join(child.cmdline()[-1:]).endswith("jobs.py")
    return found


def wait_for(what, run):
    """Poll until `what()` is true, and return it; the run must still be there."""
    while not (found := what()):
        assert run.poll() is None, run.communicate()[0]
        time.sleep(0.02)
    return found


def kill_at_once(processes):
    for process in processes:
        process.kill()
    psutil.wait_procs(processes)


@pytest.fixture
def folder(root, tmp_path):
    return Folder(root, tmp_path)


@pytest.fixture(scope="module")
def resumed(root, tmp_path_factory):
    """A run killed on its way, refused beside itself, and gone on with by the same command."""
    folder, seen = Folder(root, tmp_path_factory.mktemp("resumed")), set()
    run = folder.start()
    # With three jobs begun on two cores, one is done and on Snakemake's record.
    wait_for(lambda: seen.update(jobs_of(run)) or len(seen) == 3, run)
    before = folder.finished()
    run.send_signal(signal.SIGSTOP)
    code, output = folder.run()
    assert code != 0 and f"{folder.path}: another run is at work in this folder" in output
    assert "Traceback" not in output
    jobs = psutil.Process(run.pid).children(recursive=True)
    kill_at_once([*jobs, psutil.Process(run.pid)])
    run.communicate()
    (folder.slabs / "0123456789abcdef.nc.99.part").touch()
    code, output = folder.run()
    assert code == 0, output
    after = folder.finished()
    assert len(after) == 3
    assert sum(after[name] == written for name, written in before.items()) >= 1
    return folder


@pytest.fixture(scope="module")
def undisturbed(root, tmp_path_factory):
    folder = Folder(root, tmp_path_factory.mktemp("undisturbed"))
    code, output = folder.run()
    assert code == 0, output
    return folder


@pytest.fixture
def slabs(resumed, tmp_path):
    """Copies of the slabs of a finished run in the order of the grid, and the grid's axes."""
    study = load_config(yaml.safe_load(STUDY))
    slabs = make_plan(study.grid, study.model, study.settings).slabs
    names = [slab_name(study, slab) for slab in slabs]
    paths = [tmp_path / f"{name}.nc" for name in names]
    for path in paths:
        path.write_bytes((resumed.slabs / path.name).read_bytes())
    return paths, study.axes


def test_a_killed_run_loses_nothing(resumed):
    study = load_config(yaml.safe_load(STUDY))
    options = {"model": "cosines", "modes": 3, "horizon": 40_000.0, "until": "snap"}
    with xr.open_dataset(resumed.cube) as cube:
        xr.testing.assert_equal(cube, snapmap.sweep(study.device, **study.axes, **options))
    assert not list((resumed.path / "results").rglob("*.part"))


@pytest.mark.long
def test_a_killed_job_is_run_again(folder, undisturbed, resumed):
    run = folder.start()
    wait_for(folder.finished, run)
    kill_at_once(wait_for(lambda: jobs_of(run), run))
    output, _ = run.communicate()
    assert run.returncode == 0, output
    assert "Trying to restart job" in output
    cubes = [one.cube.read_bytes() for one in (folder, resumed)]
    assert cubes == [undisturbed.cube.read_bytes()] * 2


@pytest.fixture
def listening():
    """Ctrl-C is heard, though a shell ignores it for what it runs in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.long
def test_ctrl_c_ends_a_run_in_one_line(folder, listening):
    run = folder.start(start_new_session=True)
    jobs = wait_for(lambda: jobs_of(run), run)
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does; the jobs have hardly begun to import
    output, _ = run.communicate(timeout=60)
    assert run.returncode == 1 and not psutil.wait_procs(jobs, timeout=20)[1]
    assert "Traceback" not in output and "Error" not in output
    assert output.count("interrupted: finished files are kept") == 1


@pytest.mark.long
def test_jobs_end_with_a_killed_run(folder):
    run = folder.start()
    jobs = wait_for(lambda: jobs_of(run), run)
    run.kill()
    assert not psutil.wait_procs(jobs, timeout=20)[1]
    assert not folder.finished()


@pytest.mark.long
def test_a_broken_slab_is_refused_by_name_and_made_again(folder, undisturbed):
    shutil.copytree(undisturbed.path, folder.path, dirs_exist_ok=True)
    broken = min(folder.slabs.glob("*.nc"))
    broken.write_bytes(broken.read_bytes()[:20000])
    code, output = folder.run()
    assert code != 0 and f"results/slabs/{broken.name}: is damaged" in output
    assert "Traceback" not in output and "WorkflowError" not in output and ", line " not in output
    assert not folder.cube.exists()
    broken.unlink()
    code, output = folder.run()
    assert code == 0, output
    assert folder.cube.read_bytes() == undisturbed.cube.read_bytes()


FAULTS = {
    "truncated": lambda path, other: path.write_bytes(path.read_bytes()[:-1000]),
    "empty": lambda path, other: path.write_bytes(b""),
    "text": lambda path, other: path.write_text("N: 600\n"),
    "foreign": lambda path, other: path.write_bytes(other.read_bytes()),
    "another file": lambda path, other: xr.Dataset({"N": [600.0]}).to_netcdf(path),
    "missing": lambda path, other: path.unlink(),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_file_is_named(slabs, fault):
    paths, axes = slabs
    FAULTS[fault](paths[1], paths[2])
    with pytest.raises(ValueError) as refusal:
        collect_slabs(paths, axes, {})
    assert str(refusal.value).startswith(f"{paths[1]}: ")
    assert "\n" not in str(refusal.value)


def test_holes_and_slabs_given_twice_are_refused(slabs):
    paths, axes = slabs
    with pytest.raises(ValueError) as refusal:
        collect_slabs([paths[0]], axes, {})
    lines = str(refusal.value).splitlines()
    assert [f"C = {C} " in line for C, line in zip(axes["C"][1:], lines, strict=True)] == [True] * 2
    with pytest.raises(ValueError, match=r"3200 cells .* 2400"):
        collect_slabs([*paths, paths[-1]], axes, {})


@pytest.mark.parametrize("stride", [997, pytest.param(17, marks=pytest.mark.long)])
def test_a_flipped_byte_is_refused_or_without_effect(slabs, stride):
    (path, *_), axes = slabs
    axes = axes | {"C": axes["C"][:1]}
    whole = path.read_bytes()
    right = collect_slabs([path], axes, {}).load(scheduler="synchronous")
    refused = 0
    for place in range(0, len(whole), stride):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = collect_slabs([path], axes, {}).load(scheduler="synchronous")
        except ValueError as refusal:
            assert str(path) in str(refusal)
            refused += 1
        else:
            assert found.equals(right)
    assert refused


@pytest.mark.long
def test_a_job_out_of_memory_is_reported_by_name(folder, undisturbed):
    run = folder.start()
    starved = set()
    while run.poll() is None:
        for job in set(jobs_of(run)) - starved:
            starved.add(job)
            job.rlimit(psutil.RLIMIT_AS, (2**28, 2**28))
        time.sleep(0.02)
    output, _ = run.communicate()
    assert run.returncode != 0 and not folder.finished()
    assert "Error in rule simulate_slab" in output and "output: results/slabs/" in output
    code, output = folder.run()
    assert code == 0, output
    assert folder.cube.read_bytes() == undisturbed.cube.read_bytes()


def in_own_mounts(script, *arguments):
    """Run a shell script that may mount what it likes; skips where that is not permitted."""
    if subprocess.run([*IN_OWN_MOUNTS, "mount -t tmpfs none /tmp"], capture_output=True).returncode:
        pytest.skip("mounts are not permitted here")
    command = [*IN_OWN_MOUNTS, script, "sh", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.long
@pytest.mark.parametrize("kilobytes", [100, 190])  # too small for the slabs, or for the cube
def test_a_full_disk_is_named_and_leaves_no_broken_file(folder, undisturbed, kilobytes):
    results = folder.path / "results"
    results.mkdir()
    script = f"""
        cd "$1"; shift
        mount -t tmpfs -o size={kilobytes}k none results
        "$@" && exit 1
        find results -type f >full.txt
        mount -o remount,size=100m results
        "$@"
        cp results/cube.nc resumed.nc
    """
    code, output = in_own_mounts(script, folder.path, *folder.command)
    assert code == 0, output
    full, *_ = [line for line in output.splitlines() if "not written" in line]
    assert "MB are free there" in full and full.startswith("results/")
    left = [Path(name) for name in (folder.path / "full.txt").read_text().split()]
    assert all(path.suffix == ".log" or path.parent.name == "slabs" for path in left)
    assert (folder.path / "resumed.nc").read_bytes() == undisturbed.cube.read_bytes()


@pytest.mark.long
def test_the_clone_and_the_packages_may_be_read_only(root, folder, undisturbed):
    script = """
        for place in "$1" "$2"; do
            mount --bind "$place" "$place"
            mount -o remount,ro,bind "$place"
            if touch "$place/written" 2>/dev/null; then exit 1; fi
        done
        cd "$3"; shift 3
        exec "$@"
    """
    places = [root, Path(psutil.__file__).parents[1], folder.path]
    code, output = in_own_mounts(script, *places, *folder.command)
    assert code == 0, output
    assert folder.cube.read_bytes() == undisturbed.cube.read_bytes()


OUTER = """
import numba
from snapmap.numerics.kernels import compiled
from inner import factor

@compiled
def scaled(x):
    return factor(x) * x

print(scaled(2.0), sum(scaled.stats.cache_hits.values()), numba.config.CACHE_DIR)
"""
INNER = """
from numba import njit

@njit
def factor(x):
    return {}
"""


@pytest.mark.parametrize(
    "variable", ["XDG_CACHE_HOME", pytest.param("NUMBA_CACHE_DIR", marks=pytest.mark.long)]
)
def test_a_kernel_is_never_of_another_source(root, tmp_path, variable):
    """numba by itself would keep the first: the file of the kernel stays as it is."""
    sources = tmp_path / "sources"
    sources.mkdir()
    (sources / "outer.py").write_text(OUTER)
    path = {"PYTHONPATH": f"{sources}:{root / 'workflow' / 'scripts'}", variable: str(tmp_path)}
    users = path.get("NUMBA_CACHE_DIR", "")
    for factor, hits in ((3.0, 0), (3.0, 1), (5.0, 0)):
        (sources / "inner.py").write_text(INNER.format(factor))
        command = [sys.executable, "-B", "-c", "import outer"]
        run = subprocess.run(command, env=os.environ | path, capture_output=True, text=True)
        assert run.stdout.split() == [str(2 * factor), str(hits), *users.split()], run.stderr
    assert len({path.parent for path in tmp_path.rglob("*.nbi")}) == 2


def test_no_kernel_is_compiled_by_two_processes(root, tmp_path):
    """All start at once; what does not compile waits, and loads."""
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format(3.0))
    path = {"PYTHONPATH": f"{tmp_path}:{root / 'workflow' / 'scripts'}"}
    path["NUMBA_CACHE_DIR"] = str(tmp_path)
    command = [sys.executable, "-B", "-c", "import outer"]
    told = {"env": os.environ | path, "stdout": subprocess.PIPE, "text": True}
    runs = [subprocess.Popen(command, **told) for _ in range(3)]
    hits = [run.communicate(timeout=120)[0].split()[1] for run in runs]
    assert sorted(hits) == ["0", "1", "1"]


def test_a_kernel_that_cannot_be_kept_runs(tmp_path, monkeypatch):
    def replace(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    with monkeypatch.context() as full:
        full.setattr(os, "replace", replace)
        assert compiled(_size)((0,) * 3) == 3
    assert not [*tmp_path.rglob("*.nbc")]


def test_a_damaged_kernel_is_compiled_anew_and_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    assert compiled(_size)((0, 0)) == 2
    for path in [*tmp_path.rglob("*.nbi"), *tmp_path.rglob("*.nbc")]:
        whole = path.read_bytes()
        flips = (
            whole[:at] + bytes([whole[at] ^ 255]) + whole[at + 1 :]
            for at in range(0, len(whole), len(whole) // 5)
        )
        for damaged in (*flips, whole[: len(whole) // 2], b""):
            path.write_bytes(damaged)
            for hits in (0, 1):
                kernel = compiled(_size)
                assert kernel((0, 0)) == 2
                assert sum(kernel.stats.cache_hits.values()) == hits


def test_what_is_compiled_is_told_once(tmp_path, monkeypatch, recwarn):
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    for _ in range(2):
        assert njit(cache=True)(_size)((0,) * 23) == 23
    assert ["23 modes" in str(one.message) for one in recwarn] == [True]


def _size(shape):
    return len(shape)
