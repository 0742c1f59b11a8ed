"""Numbers of numpy's and xarray's in calls: each is one of Python's behind the door."""

import inspect
import json

import numpy as np
import pytest
import xarray as xr

import snapmap
from snapmap.device.argument import argument_of
from snapmap.public import options_of
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.options import OF_MODEL

WHOLE = (np.int64, np.int32, lambda number: np.array(int(number)))
KINDS = (*WHOLE, np.float32, np.float64, np.array, xr.DataArray)
SEVERAL = (np.array, xr.DataArray, tuple, lambda row: [*map(np.float32, row)])
RIGHT = {
    **{"samples": 8, "index_samples": 8, "seed": 3, "records": 2, "threads": 1, "elements": 3},
    **{"cosines": 3, "modes": 3, "step": 0.5, "horizon": 64.0, "duration": 2.0, "highest": 2000.0},
    **{"energy_tolerance": 0.25, "reach": 0.5, "confidence": 0.5, "reliability": 0.5},
    **{"failures": 1, "between": [1.75, 2.25], "psd": [[20.0, 0.5], [2000.0, 0.5]]},
    **{"srs": [[500.0, 700.0], [2000.0, 1500.0]], "N": 1000.0, "f0": 1500.0, "C": 25.0},
    **{"unknowns": {"thickness": [1.75, 2.25], "C": [1.0, 32.0]}, "tolerance": 2.0**-7},
    "scatters": {"thickness": 0.125, "rise": {"uniform": 0.5}, "depth": "5 %"},
    "requirements": [{"name": "a", "N": 500.0, "f0": 1500.0, "snaps": True}],
    **{"time": [0.0, 1.0, 2.0], "acceleration": [0.0, 1.0, 0.0], "restitution": 0.5},
    **dict.fromkeys(("contact_at", "residual_stress"), -8.0),
}
"""Values that a float of 32 bits holds, too; of all others 2."""
NO_NUMBERS = {
    *("ax", "cube", "direction", "earlier", "ends", "found", "laws", "mass_matrix", "method"),
    *("device", "model", "name", "path", "prior", "pulse", "repeat", "sha256", "shots", "skip"),
    *("start", "studies", "together", "until", "value", "x", "y"),
}
FUNCTIONS = {name: getattr(snapmap, name) for name in snapmap.__all__ if name != "reference"}
"""All but the one that takes functions alone."""


def arguments_of(function):
    """What a function takes, with its options and those of its models."""
    named = inspect.signature(function).parameters
    arguments = {key: argument_of(of.annotation) for key, of in named.items() if key != "options"}
    return (OF_MODEL if "model" in named else {}) | arguments | options_of(function)


def converted(value, kind):
    """The value with each of its numbers as another kind."""
    if isinstance(value, dict):
        return {key: converted(inner, kind) for key, inner in value.items()}
    if isinstance(value, list):
        return [converted(inner, kind) for inner in value]
    return value if isinstance(value, str | bool) else kind(value)


def kinds_of(value):
    """A right value in other kinds of number."""
    if isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict)):
        return [converted(value, kind) for kind in (np.float32, np.float64, xr.DataArray)]
    if isinstance(value, list):
        return [kind(value) for kind in SEVERAL]
    kinds = WHOLE if isinstance(value, int) else KINDS
    return [kind(value) for kind in kinds if float(kind(value)) == value]


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name[0].islower()])
def test_each_numeric_argument_of_each_function_takes_each_kind(name):
    arguments = arguments_of(FUNCTIONS[name])
    for key in arguments.keys() - NO_NUMBERS:
        right = RIGHT.get(key, 2.0)
        for value in kinds_of(right):
            behind = arguments[key].take(key, value)
            if isinstance(behind, np.ndarray):
                assert behind.dtype == float and type(behind) is np.ndarray
                behind = behind.tolist() if np.ndim(right) else behind.item()
            assert json.loads(json.dumps(behind)) == right, (key, value)
            assert type(behind) is type(right), (key, value)


def test_a_row_is_an_array_of_floats():
    for row in kinds_of([500.0, 1500.0]):
        behind = arguments_of(snapmap.sweep)["f0"].take("f0", row)
        assert behind.dtype == float and behind.tolist() == [500.0, 1500.0]


def test_numbers_of_pulses_are_plain():
    whole, part = np.int64(2), np.float32(0.5)
    train = [{"duration": whole, "N": part}, {"wait": xr.DataArray(5)}, {"repeat": whole}]
    drop = {"height": np.array(1e6), "duration": np.int64(500), "rebound": part}
    trapezoid = {"shape": "trapezoid", "rise": part, "fall": np.float64(0.25)}
    for pulse in ({"train": train}, {"drop": drop}, trapezoid):
        section = make_shocks(pulse).section()
        assert json.loads(json.dumps(section)) == section and "np." not in str(section)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64, np.array, xr.DataArray])
def test_calls_give_the_same_by_numbers_of_each_kind(handout, kind):
    shock = {"N": 1000, "f0": 1500, "C": 25}
    plain = {**shock, "model": "cosines", "modes": 3, "horizon": 0.0}
    other = {**plain, **{key: kind(shock[key]) for key in shock}}
    other |= {"modes": np.int64(3), "horizon": kind(0)}
    run = snapmap.simulate(handout, **other)
    assert run.identical(snapmap.simulate(handout, **plain))
    cube = snapmap.sweep(handout, **other, until="snap", energy_tolerance=np.float32(0.25))
    assert cube.identical(snapmap.sweep(handout, **plain, until="snap", energy_tolerance=0.25))
    for made in (run, cube):
        assert "np." not in made.attrs["config"] and json.loads(made.attrs["config"])
