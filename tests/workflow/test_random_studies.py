"""Studies of combined features, made at random, run whole or are refused before the first job."""

import pytest
import yaml
from products import assert_whole
from random_studies import FILES, random_study
from small_workflow import snakemake

from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError

SEEDS = range(10)
FEATURES = (
    "force:",
    "guide:",
    "stops:",
    "contact_at:",
    "strength:",
    "devices:",
    "train:",
    "file:",
    "drop:",
)
FEATURES += "both", "start:", "srs:", "psd:", "close", "tolerances:", "calibration:"
FEATURES += "histories:", "laws:", "marks:", "maps:", "spacing: log", "skip"


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
    documents = [yaml.safe_load(random_study(seed)) for seed in range(100, 130)]
    read = [load_config(document) for document in documents if not is_refused(document)]
    assert len(read) > 20
    for feature in FEATURES:
        assert any(feature in yaml.safe_dump(document) for document in documents), feature


def is_refused(document):
    try:
        load_config(document)
    except ConfigError as error:
        assert all(": " in line for line in str(error).splitlines())
        return True
    return False
