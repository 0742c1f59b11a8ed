"""The command `snapmap`, and what a package without its extras says."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import snapmap
from snapmap.command import START, _costs, main
from snapmap.config.doubts import descriptions, doubts
from snapmap.config.study import load_config
from snapmap.config.yaml_file import read_document


@pytest.fixture
def config(tmp_path):
    assert main(["init", str(tmp_path / "study")]) == 0
    return tmp_path / "study" / "config.yaml"


def test_init_writes_the_config_that_there_is_and_nothing_over_another(root, config, capsys):
    text = config.read_text(encoding="utf-8")
    assert text == (root / "config" / "sensor.yaml").read_text(encoding="utf-8")
    config.write_text("mine")
    assert main(["init", str(config.parent)]) == 1
    assert capsys.readouterr().err.startswith(f"{config}: is there already")
    assert config.read_text() == "mine"
    config.unlink()
    config.symlink_to("elsewhere.yaml")
    assert main(["init", str(config.parent)]) == 1
    assert not (config.parent / "elsewhere.yaml").exists()


def test_check_says_what_a_config_describes_doubts_and_costs(config, capsys):
    capsys.readouterr()
    assert main(["check", str(config)]) == 0
    told = capsys.readouterr().out.splitlines()
    study = load_config(read_document(config))
    assert told[:-2] == [*descriptions(study), *doubts(study)]
    assert told[-2].startswith("1938 cells (C 2, f0 17, N 57) in ")
    for what in ("cells", *_costs(study)):
        assert re.search(rf"[:,] {what} [0-9.]+ (s|min|h)", told[-1])


def test_check_says_what_else_it_costs(config):
    """In equal steps of the samples."""
    document = read_document(config)
    document["requirements"] = [{"name": "drop", "N": 900, "f0": "1 kHz", "snaps": False}]
    costs = []
    for samples in (2000, 4000, 6000):
        document["tolerances"] = {"thickness": "1 %", "samples": samples, "index_samples": 2}
        costs.append(_costs(load_config(document)))
        assert {"thresholds", "requirements", "tolerances", "data sheet"} < set(costs[-1])
    steps = np.diff([cost["tolerances"] for cost in costs])
    assert steps[0] > 0 and steps[1] == pytest.approx(steps[0])
    del document["tolerances"]
    assert "tolerances" not in _costs(load_config(document))


def test_check_says_what_vibration_calibration_and_histories_cost(config, tmp_path, monkeypatch):
    """In proportion to the spectra and the histories, and to the points over the ranges."""
    monkeypatch.chdir(tmp_path)
    Path("shots.csv").write_text("N,duration (ms),tripped\n800,1,no\n900,1,no\n1000,1,yes\n")
    document = read_document(config)
    ranges = {"thickness": ["1.5 um", "1.7 um"], "rise": ["7.9 um", "8.1 um"]}
    psd = [["100 Hz", "4 g^2/Hz"], ["2000 Hz", "4 g^2/Hz"]]
    costs = []
    for count in (1, 2):
        names = [f"road {i}" for i in range(count)]
        shaken = {"psd": psd, "duration": "0.1 s", "snaps": False}
        document["requirements"] = [{"name": name, **shaken} for name in names]
        struck = {"srs": [["500 Hz", "70 g"], ["2000 Hz", "150 g"]], "snaps": False}
        document["requirements"] += [{"name": f"shock {name}", **struck} for name in names]
        cells = [{"N": 900 + i, "f0": "1 kHz", "C": "5 uN*us/um"} for i in range(count)]
        unknowns = dict(list(ranges.items())[:count])
        calibration = {"shots": "shots.csv", "unknowns": unknowns, "C": "5 uN*us/um"}
        document |= {"histories": cells, "calibration": calibration}
        costs.append(_costs(load_config(document)))
    one, two = costs
    for what in ("vibration", "spectra"):
        assert one[what] > 0 and two[what] == pytest.approx(2 * one[what])
    assert two["histories"] - one["histories"] == START
    assert two["calibration"] / one["calibration"] == pytest.approx((64 + 17**2) / (64 + 33))


def test_run_is_snakemake_with_the_workflow(root, config, monkeypatch):
    asked = []
    monkeypatch.setattr("snakemake.cli.main", asked.extend)
    assert main(["run", str(config), "--cores", "2"]) == 0
    files = ["--snakefile", str(root / "Snakefile"), "--configfile", str(config)]
    assert asked == [*files, "--cores", "2"]
    asked.clear()
    assert main(["run", str(config), "-n", "results/cube.nc"]) == 0
    assert asked == [*files, "--cores", "all", "-n", "results/cube.nc"]
    with pytest.raises(SystemExit):
        main(["check", str(config), "-n"])


def test_run_refuses_what_snakemake_would_evaluate(config, monkeypatch, capsys):
    monkeypatch.setattr("snakemake.cli.main", pytest.fail)
    config.write_text("__use_yte__: true\n")
    assert main(["run", str(config)]) == 1
    assert "__use_yte__" in capsys.readouterr().err


def test_a_missing_package_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pydantic", None)
    monkeypatch.delattr(snapmap, "load_device", raising=False)
    for name in [name for name in sys.modules if name.startswith("snapmap.config")]:
        monkeypatch.delitem(sys.modules, name)
    said = r"snapmap\.load_device needs pydantic: pip install 'snapmap\[config\]'"
    with pytest.raises(ImportError, match=f"^{said}$"):
        snapmap.load_device()
