"""The command `snapmap`, and what a package without its extras says."""

import re
import sys

import pytest
from small_workflow import snakemake

import snapmap
from snapmap.applications.whole import doubts, load_config
from snapmap.config.doubts import descriptions
from snapmap.config.yaml_file import read_document
from snapmap.workflow.command import main


@pytest.fixture
def config(tmp_path):
    assert main(["init", str(tmp_path / "study")]) == 0
    return tmp_path / "study" / "config.yaml"


def test_init_writes_the_config_that_there_is_and_nothing_over_another(root, config, capsys):
    assert config.read_bytes() == (root / "config" / "sensor.yaml").read_bytes()
    config.write_text("mine")
    assert main(["init", str(config.parent)]) == 1
    assert capsys.readouterr().err.startswith(f"{config}: exists already")
    assert config.read_text() == "mine"
    config.unlink()
    config.symlink_to("elsewhere.yaml")
    assert main(["init", str(config.parent)]) == 1
    assert not (config.parent / "elsewhere.yaml").exists()


def test_check_says_what_a_config_describes_doubts_and_costs(root, config, capsys):
    """What it says of the device stands in the tutorial, too."""
    assert main(["check", str(config)]) == 0
    *lines, cells, others, costs = capsys.readouterr().out.splitlines()
    study = load_config(read_document(config))
    assert lines == [*descriptions(study), *doubts(study)]
    assert f"`{lines[0]}`" in (root / "docs" / "tutorial.md").read_text(encoding="utf-8")
    assert cells.startswith("1938 cells (C 2, f0 17, N 57) in ")
    made = 2 * (17 * (200 + 128 * 4) + 2 * 200)  # of samples, indices and required shocks
    assert {f"thresholds of devices as made {made}", "verdicts 4"} < {*others.split(", ")}
    assert re.fullmatch(r"core time, about: [0-9.]+ (s|min|h)", costs)


def test_run_is_snakemake_with_the_workflow(root, config, monkeypatch):
    asked = []
    monkeypatch.setattr("snakemake.cli.main", asked.append)
    assert main(["run", str(config), "--cores", "2"]) == 0
    assert main(["run", str(config), "-n", "results/cube.nc"]) == 0
    profile = root / "profiles" / "default" / "profile.yaml"
    files = ["--configfile", str(config), "--snakefile", str(root / "Snakefile")]
    files += ["--workflow-profile", str(profile)]
    assert main(["run", str(config), "--profile", "slurm"]) == 0  # which says how many cores
    options = ["--cores", "2"], ["--cores", "all", "-n", "results/cube.nc"], ["--profile", "slurm"]
    assert asked == [[*files, *words] for words in options]
    with pytest.raises(SystemExit):
        main(["check", str(config), "-n"])


def test_help_says_what_a_config_is_and_where_results_go(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    for words in ("YAML file of a study", "results/ of the current folder", "those of Snakemake"):
        assert words in said


def test_a_profile_in_the_folder_of_a_study_is_not_read(root, tmp_path, monkeypatch):
    """As the workflow has one of its own, which `run` names."""
    (tmp_path / "profiles" / "default").mkdir(parents=True)
    code = "import pathlib\n  - pathlib.Path('executed').touch()"
    profile = f"__use_yte__: true\n__definitions__:\n  - {code}\ncores: 1\n"
    (tmp_path / "profiles" / "default" / "profile.yaml").write_text(profile)
    monkeypatch.chdir(tmp_path)
    own = "--workflow-profile", root / "profiles" / "default" / "profile.yaml"
    _, said = snakemake(root, tmp_path, root / ".test/config/config.yaml", *own, "--dry-run")
    assert "find_threshold" in said
    assert not (tmp_path / "executed").exists()


def test_run_refuses_what_snakemake_would_evaluate(config, monkeypatch, capsys):
    monkeypatch.setattr("snakemake.cli.main", pytest.fail)
    config.write_text("__use_yte__: true\n")
    assert main(["run", str(config)]) == 1
    assert "__use_yte__" in capsys.readouterr().err


def test_a_missing_package_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "yaml", None)
    monkeypatch.delattr(snapmap, "load_device", raising=False)
    for name in [name for name in sys.modules if name.startswith("snapmap.config")]:
        monkeypatch.delitem(sys.modules, name)
    said = r"snapmap\.load_device needs yaml: pip install 'snapmap\[config\]'"
    with pytest.raises(ImportError, match=f"^{said}$"):
        snapmap.load_device()


def test_the_command_says_its_version(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    said = capsys.readouterr().out
    assert not ended.value.code and said == f"snapmap {snapmap.__version__}\n"
