"""What several tests study, and how a study is changed or refused."""

import copy
from functools import reduce
from operator import getitem
from pathlib import Path

import pytest
import yaml

from snapmap.applications.whole import load_config
from snapmap.values.faults import Faults

MISSING = object()


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


TINY = (Path(__file__).parents[1] / ".test" / "config" / "config.yaml").read_text()

THREE_COSINES = """
device:
  beam: {span: 600 um, rise: 10 um, thickness: 2 um, depth: 22 um, youngs_modulus: 150 GPa,
         density: 2330 kg/m^3}
  mass: 1e-8 kg
  spring: 5.5 N/m
  contact: 40 N/m
  gravity: 9.81 m/s^2
model: {name: cosines, modes: 3}
"""
"""The handout's device with its cheapest model; a sweep is to be added."""

EVERY_PRODUCT = """
device:
  beam: {span: 500 um, rise: 8 um, thickness: 1.9 um, depth: 20 um, youngs_modulus: 160 GPa,
         density: 2330 kg/m^3, damping: 4e-3 /us}
  mass: 6e-9 kg
  spring: 4 N/m
  contact: 60 N/m
  gravity: 9.81 m/s^2
  strength: 1.2 GPa
  contact_at: -4 um
model: {name: cosines, modes: 3}
pulse: {shape: [half sine, sawtooth], direction: both}
sweep:
  N: {from: 200, to: 3000, points: 3}
  f0: [800 Hz, 2 kHz]
  C: [30 uN*us/um]
run: {horizon: 200 us}
requirements:
  - {name: crash, shape: half sine, N: 2000, f0: 1 kHz, snaps: true, closes_within: 1 ms}
  - {name: drop, shape: half sine, N: 300, f0: 2 kHz, direction: -z, snaps: false}
  - {name: setback, N: 5000, f0: 5 kHz, snaps: any}
  - {name: shaking, psd: [[100 Hz, 0.1 g^2/Hz], [2 kHz, 0.1 g^2/Hz]], duration: 10 ms, snaps: false}
  - {name: spectrum, srs: [[500 Hz, 200 g], [5 kHz, 200 g]], snaps: false}
tolerances: {thickness: 0.05 um, N: 2 %, samples: 8}
calibration: {shots: shots.csv, unknowns: {thickness: [1.7 um, 2.1 um]}, C: 30 uN*us/um}
histories:
  - {N: 1000, f0: 2 kHz, C: 30 uN*us/um}
laws: true
"""
"""Two shapes along both directions, and all that can be asked beside them; SHOTS is its table."""
SHOTS = "N,duration (ms),tripped\n900,1,no\n1500,1,yes\n1200,1,no\n1350,1,yes\n"
