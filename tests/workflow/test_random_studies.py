"""Studies of combined features, made at random, run whole or are refused before the first job."""

import random

import pytest
import yaml
from products import assert_whole
from random_studies import FILES, Drawn, random_study
from small_workflow import snakemake

from snapmap.applications.whole import load_config
from snapmap.values.faults import Faults

SEEDS = 0, 2, 3, 6, 7, 8, 12, 15, 16, 17
FEATURES = "force: free: stop_away: contact_at: strength: strength_modulus: damper_exponent: both "
FEATURES += "devices: train: file: drop: start: srs: psd: close tolerances: calibration: maps: "
FEATURES = [*f"{FEATURES} skip histories: laws: marks:".split(), "spacing: log"]


@pytest.mark.long
@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_study_runs_whole_or_is_refused_in_lines(root, tmp_path, monkeypatch, seed):
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        (tmp_path / name).write_text(content)
    (config := tmp_path / "mine.yaml").write_text(text := random_study(seed))
    code, output = snakemake(root, tmp_path, config, check=False)
    assert "Traceback" not in output, output
    if code == 0:
        assert_whole(tmp_path, load_config(yaml.safe_load(text)))
    else:
        assert not (tmp_path / "results").exists(), output


def test_random_studies_have_all_features_and_are_read_or_refused_in_lines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        (tmp_path / name).write_text(content)
    drawn = [yaml.safe_dump(Drawn(random.Random(seed)).document()) for seed in range(100)]
    for feature in FEATURES:
        assert any(feature in text for text in drawn), feature
    assert sum(map(is_refused, drawn[:20])) < 10


def is_refused(text):
    try:
        load_config(yaml.safe_load(text))
    except Faults as error:
        assert all(": " in line for line in str(error).splitlines())
        return True
    return False
