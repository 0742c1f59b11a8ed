"""The schema by which editors complete and check a config says what the records say."""

import copy
import json
import re
import runpy

import pytest
import yaml
from jsonschema import Draft202012Validator
from small_studies import cases_of

from snapmap.applications.whole import Document
from snapmap.values.records import hints

NAMES = "arm", "config", "damped", "fine", "handout", "sensor"
CONFIGS = [*(f"config/{name}.yaml" for name in NAMES), ".test/config/config.yaml"]
NAMED = re.compile(r"# yaml-language-server: \$schema=(\S+)\n")


@pytest.fixture(scope="module")
def made(root):
    """What docs/make_config_reference.py defines."""
    return runpy.run_path(str(root / "docs" / "make_config_reference.py"))


@pytest.fixture(scope="module")
def schema(made):
    return json.loads(made["written"]())


@pytest.fixture(scope="module")
def validator(schema):
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


@pytest.fixture(scope="module")
def sensor(root):
    return yaml.safe_load((root / "config" / "sensor.yaml").read_text(encoding="utf-8"))


def test_the_file_is_what_the_records_say(root, made, schema):
    assert (root / "config" / "schema.json").read_text(encoding="utf-8") == made["written"]()
    assert schema["$schema"] == made["DIALECT"]
    assert {*schema["properties"]} == {*hints(Document)}


def test_each_key_has_its_sentence_and_no_key_is_snakemakes(schema):
    def sections(part):
        if isinstance(part, dict):
            yield from [part] if part.get("additionalProperties") is False else []
            for inner in part.values():
                yield from sections(inner)
        for inner in part if isinstance(part, list) else ():
            yield from sections(inner)

    of_records = [part for part in sections(schema) if "description" in part]
    assert len(of_records) > 15
    for part in of_records:
        for key, about in part["properties"].items():
            assert about["description"], key
    assert "threads" not in schema["properties"]["run"]["properties"]


def test_defaults_have_units(schema):
    run, device = schema["properties"]["run"], schema["properties"]["device"]
    assert run["properties"]["horizon"]["default"] == "1500 us"
    assert device["properties"]["gap"]["default"] == "0 um"
    assert device["properties"]["beam"]["properties"]["damping"]["default"] == "0 /us"
    assert device["properties"]["beam"]["properties"]["free"]["default"] is False


@pytest.mark.parametrize("name", CONFIGS)
def test_the_configs_of_the_project_are_valid_and_name_it(root, validator, name):
    path = root / name
    text = path.read_text(encoding="utf-8")
    assert (path.parent / NAMED.match(text)[1]).resolve() == root / "config" / "schema.json"
    document = yaml.safe_load(text)
    assert not [*validator.iter_errors(document)]


def test_every_config_of_the_project_is_among_them(root):
    found = [*root.glob("config/*.yaml"), *root.glob(".test/**/*.yaml")]
    assert {str(path.relative_to(root)) for path in found} == {*CONFIGS}


CASES = cases_of(__file__)


@pytest.mark.parametrize("where", CASES["wrong"])
def test_mistakes_are_marked(validator, sensor, where):
    path, value = CASES["wrong"][where]
    document = copy.deepcopy(sensor)
    *above, last = (int(key) if key.isdigit() else key for key in path.split("."))
    section = document
    for key in above:
        section = section[key]
    section.pop(last) if value is None else section.__setitem__(last, value)
    assert [*validator.iter_errors(document)]


@pytest.mark.parametrize("what", CASES["right"])
def test_what_is_right_is_not_marked(validator, sensor, what):
    device = {k: v for k, v in (sensor["device"] | CASES["right"][what]).items() if v is not None}
    assert not [*validator.iter_errors(sensor | {"device": device})]


def test_the_page_of_the_config_has_each_key_with_its_sentence(root, made):
    page = (root / "docs" / "config.md").read_text(encoding="utf-8")
    assert made["reference"]() == page
    assert "| `horizon` | time followed after the pulse's end |" in page
    assert "| `1500 us` |" in page and "threads" not in page
    assert page.count("| `stop_toward`, `stop_away` |") == 1  # values of the device are said once
