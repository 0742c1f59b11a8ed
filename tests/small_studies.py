"""What several tests study, and how a study is changed or refused."""

import copy
from functools import reduce
from operator import getitem
from pathlib import Path

import pytest
import yaml

from snapmap.applications.whole import load_config
from snapmap.values.faults import Faults

MISSING = None
"""In place of a value that is left out, as null in YAML."""


def cases_of(path):
    """Give the tables of cases in the YAML file beside a file of tests."""
    return yaml.safe_load(Path(path).with_suffix(".yaml").read_text(encoding="utf-8"))


def changed(document, **values):
    """The document with values set, or MISSING, at paths such as device__beam__span."""
    document = copy.deepcopy(document)
    for path, value in values.items():
        *parents, last = path.split("__")
        section = reduce(getitem, parents, document)
        section[last] = value
        if value is MISSING:
            del section[last]
    return document


def faults(document):
    """The lines that refuse a document."""
    with pytest.raises(Faults) as caught:
        load_config(document)
    lines = str(caught.value).splitlines()
    assert lines == [*caught.value.args] and all(len(line) < 300 for line in lines)
    return lines


HERE = Path(__file__).parent
TINY, THREE_COSINES, EVERY_PRODUCT = (
    (HERE / name).read_text(encoding="utf-8")
    for name in ("../.test/config/config.yaml", "three_cosines.yaml", "every_product.yaml")
)
"""The smallest study; one without a sweep, which is to be added; and one that asks for all."""
SHOTS = "N,duration (ms),tripped\n900,1,no\n1500,1,yes\n1200,1,no\n1350,1,yes\n"
"""The table of shots of EVERY_PRODUCT."""
