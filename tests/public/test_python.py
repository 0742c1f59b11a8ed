"""The functions of the package: what there is, what they take, and what a wrong call says."""

import doctest
import inspect
import itertools
import json
import pickle
import random
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import snapmap
from snapmap.device.argument import argument_of
from snapmap.device.device import Beam, Device, batch
from snapmap.public import options_of
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.options import OF_MODEL, OPTIONS

SINGLE = {"N": 1000.0, "f0": 1500.0, "C": 25.0}
CHEAP = {"model": "cosines", "modes": 3, "horizon": 0.0}
DEVICE = Device(Beam(600.0, 10.0, 2.0, 22.0, 150e3, 2.33e-3), 1e4, 5.5, 40.0, 9.81e-6)
SHOTS = {"N": [800, 900, 950, 1000], "tripped": [0, 0, 1, 1], "duration": [1000.0] * 4}
WRONG = (
    *(None, "abc", "1500 Hz", "", b"abc", "a\nb", np.nan, np.inf, -np.inf, -1.0, 0.5j, 10**400),
    *([], (), {}, [[]], [[1.0], [2.0, 3.0]], [[[1.0]]], ["abc"], [None], [np.nan], [-1.0]),
    *({"name": []}, [[1.0]], [memoryview(b"a")], batch([DEVICE, DEVICE])),
    *({"abc": 1}, {1: [2]}, {"N": "abc"}, {1.0, 2.0}, object(), object, len, range(0), ...),
    *(np.ones(100_000), np.array(["abc"]), np.array(None), np.zeros((2, 3, 4)), "abc" * 10_000),
)
"""Right for no argument but those of `RIGHT`."""
BELOW_ZERO = "temperature", "residual_stress", *(f"cosine_{n}" for n in range(2, 6))
RIGHT = {
    **dict.fromkeys(BELOW_ZERO, (-1.0, [-1.0])),
    **dict.fromkeys(("contact", "clamp_axial", "stop_toward", "stop_away"), (np.inf,)),
    **{"sha256": ("",), "requirements": ([], ()), "together": ([], (), [[]]), "C": ((),)},
}
FUNCTIONS = {name: getattr(snapmap, name) for name in snapmap.__all__}
VERBS = [name for name in FUNCTIONS if name[0].islower()]


def test_a_device_of_several_values_is_told_what_it_lacks():
    for wrong in (replace(DEVICE, mass=[1e4, 2e4]), {"a": DEVICE, "b": batch([DEVICE])}):
        with pytest.raises(ValueError, match=r"\Adevice: .*, each value a number; load_device"):
            snapmap.sweep(wrong, **SINGLE)


def parameters_of(name):
    return inspect.signature(FUNCTIONS[name]).parameters


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_example_of_each_function_is_true(root, monkeypatch, name):
    monkeypatch.chdir(root)
    finder = doctest.DocTestFinder(recurse=False)
    (example,) = finder.find(FUNCTIONS[name], name, globs={"snapmap": snapmap})
    assert example.examples and doctest.DocTestRunner().run(example).failed == 0


@pytest.mark.parametrize("name", VERBS)
def test_the_signature_shows_what_each_argument_may_be(name):
    shown = str(inspect.signature(FUNCTIONS[name]))
    for key, parameter in parameters_of(name).items():
        assert key == "options" or argument_of(parameter.annotation).need in shown, key


@pytest.fixture(scope="module")
def right_calls(handout, root):
    """A right call of each function."""
    cube = snapmap.sweep(handout, [900.0, 1000.0], [1500.0], [25.0], until="snap", **CHEAP)
    at = {"device": handout, **CHEAP}
    several = {**at, **{key: [SINGLE[key]] for key in SINGLE}}
    no_N = {key: several[key] for key in several if key != "N"}
    no_f0 = {key: no_N[key] for key in no_N if key not in ("f0", "horizon")}
    pairs = [(500, 700), (2000, 1500)]
    return {
        "calibrate": {"shots": SHOTS, "unknowns": {"thickness": (1.7, 2.3)}, **at, "C": 25.0},
        "design": {"value": "thickness", **SINGLE, "between": (1.8, 2.2), **at},
        "load_device": {"path": root / "config/config.yaml"},
        "open_cube": {"path": root / "no.nc"},
        "plot_outcome": {"cube": cube, "ax": None, "x": "f0", "y": "N", "ends": False},
        "read_pulse": {"path": root / "config/half_sine.csv", "sha256": ""},
        "simulate": {**SINGLE, **at},
        "srs_test": {"srs": pairs, "records": 1, "seed": 1, **no_f0},
        "statics": {"device": handout},
        "sweep": several,
        "threshold": {**no_N, "tolerance": 1e-3, "highest": 2000.0},
        "tolerance": {"scatters": {"thickness": "5 %"}, **several, "tolerance": 1e-3, "samples": 8},
        "vibration": {"psd": pairs, "duration": 0.01, "records": 1, "seed": 1, **no_f0},
    }


def wrong_calls(right_calls):
    """Each function with each argument and option, one at a time, as each of WRONG."""
    for name, right in right_calls.items():
        parameters = parameters_of(name)
        options = {*options_of(FUNCTIONS[name])}
        options |= {*OPTIONS["cosines"]} if "model" in right else set()
        keys = {*parameters, *right, *options} - {"options"}
        for key, value in itertools.product(sorted(keys), WRONG):
            annotation = getattr(parameters.get(key), "annotation", "")
            alike = (type(one) is type(value) and one == value for one in RIGHT.get(key, ()))
            if not any(alike) and not (value is None and "None" in str(annotation)):
                yield name, right, key, value


NESTED = {
    "pulse": [
        {"train": [{"duration": 100.0}, {"wait": 5.0}, {"repeat": 2}]},
        {"drop": {"height": 1e5, "duration": 500.0, "rebound": 0.5, "shape": "half sine"}},
    ],
    "shots": [{**SHOTS, "direction": ["+z"] * 4, "shape": ["half sine"] * 4}],
    "unknowns": [{"thickness": (1.7, 2.3)}],
    "scatters": [{"thickness": "5 %"}, {"thickness": {"uniform": "5 %"}}],
    "requirements": [[{"name": "drop", "N": 500.0, "f0": 1500.0, "snaps": False}]],
}
"""Right values of which a part can be wrong."""


def wrong_parts(value):
    """The value, each of its parts, however deep, as each of WRONG."""
    places = range(len(value)) if isinstance(value, list) else ()
    for key in value if isinstance(value, dict) else places:
        for part in (*WRONG, *wrong_parts(value[key])):
            changed = value.copy()
            changed[key] = part
            yield changed


def nested_wrong_calls(right_calls):
    """Each function with each part of its arguments that have some as each of WRONG."""
    for name, right in right_calls.items():
        taken = {*parameters_of(name), *options_of(FUNCTIONS[name])}
        for key in [key for key in NESTED if key in taken]:
            for value in itertools.chain.from_iterable(map(wrong_parts, NESTED[key])):
                yield name, right, key, value


def fault_of(name, arguments, key):
    """What is wrong with the complaint about a wrong argument, or nothing."""
    try:
        FUNCTIONS[name](**arguments)
    except (ValueError, TypeError) as fault:
        text = str(fault)
        named = text.startswith((key, f"model.{key}", "tolerances.", str(arguments[key])))
        return "" if named and "\n" not in text and len(text) < 200 else text
    except Exception as fault:
        return repr(fault)[:200]
    return "passes"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("calls", [1000, pytest.param(100_000, marks=pytest.mark.long)])
def test_a_wrong_argument_is_one_line_that_names_it(right_calls, calls):
    every = [*wrong_calls(right_calls), *nested_wrong_calls(right_calls)]
    drawn = random.Random(1).sample(every, min(calls, len(every)))
    faults = {}
    for name, right, key, value in drawn:
        if fault := fault_of(name, {**right, key: value}, key):
            faults[name, key, repr(value)[:30]] = fault
    # A few of these are right in their place, as is a cell of shots that is empty.
    unclear = {call: fault for call, fault in faults.items() if fault != "passes"}
    assert len(unclear) <= 0.001 * len(drawn), unclear
    assert len(faults) <= 0.01 * len(drawn), faults


DROP = NESTED["requirements"][0][0]
BEYOND = (
    *(("sweep", "f0", [1500.0] * 2), ("sweep", "threads", 0), ("sweep", "energy_tolerance", 1.0)),
    *(("sweep", "horizon", -1e-9), ("sweep", "skip", [True]), ("threshold", "direction", [])),
    ("threshold", "threads", 1025),
    *(("threshold", "tolerance", 0.0100001), ("simulate", "direction", "both")),
    *(("simulate", "start", "third"), ("srs_test", "seed", 2**32), ("vibration", "seed", -1)),
    *(("vibration", "direction", ["+z"] * 2), ("vibration", "psd", [(2000, 4.0), (200, 4.0)])),
    *(("tolerance", "samples", 8.5), ("tolerance", "scatters", {"beam": 1.0})),
    *(("tolerance", "requirements", [DROP | wrong]) for wrong in ({"name": 3}, {"N": 0.0})),
    ("tolerance", "requirements", [{"name": "drop", "N": 500.0}]),
)


def test_a_value_just_beyond_the_right_ones_is_one_line_that_names_it(right_calls):
    for name, key, value in BEYOND:
        assert fault_of(name, {**right_calls[name], key: value}, key) == "", (name, key)


def test_a_misspelt_option_is_named_with_the_right(right_calls):
    rng = random.Random(2)
    for name, right in right_calls.items():
        for option in options_of(FUNCTIONS[name]):
            at = rng.randrange(1, len(option))
            wrong = option[:at] + option[at + 1 :]
            with pytest.raises(ValueError, match=rf"^{wrong}: is not an option; did you mean "):
                FUNCTIONS[name](**right, **{wrong: 1})


def test_what_is_missing_or_there_twice_or_too_much_is_named(right_calls):
    for name, right in right_calls.items():
        parameters = parameters_of(name)
        for key in parameters:
            if parameters[key].default is inspect.Parameter.empty and key != "options":
                with pytest.raises(TypeError, match=f"^{key}: missing; write "):
                    FUNCTIONS[name](**{other: right[other] for other in right if other != key})
        first = next(iter(parameters))
        with pytest.raises(TypeError, match=f"^{first}: comes twice"):
            FUNCTIONS[name](right[first], **right)
        most = len(parameters.keys() - {"options"})
        with pytest.raises(TypeError, match=f"^{name}: takes {most} arguments, not {most + 1}"):
            FUNCTIONS[name](*range(most + 1))


def test_a_function_can_be_sent_to_other_processes():
    assert pickle.loads(pickle.dumps(snapmap.sweep)) is snapmap.sweep


def test_a_map_has_two_axes(right_calls):
    cube = right_calls["plot_outcome"]["cube"]
    for x, y in (("N", "N"), ("f0", "duration")):
        with pytest.raises(ValueError, match=f"^x: '{x}' is already y"):
            snapmap.plot_outcome(cube, x=x, y=y)


def test_what_takes_long_is_told_before_it_begins(handout, monkeypatch):
    monkeypatch.setattr("snapmap.solver.cost.WORTH_SAYING", 0.0)
    shaken = {"C": [25.0], "records": 1, "model": "cosines", "modes": 3}
    psd, srs = [(200, 4.0), (2000, 4.0)], [(500, 700), (2000, 1500)]
    with pytest.warns(UserWarning, match=r"^srs_test: .*, most of it at a record of"):
        snapmap.srs_test(handout, srs, **shaken, horizon=0.0)
    with pytest.warns(UserWarning, match=r"^vibration: .*, most of it at a record of"):
        snapmap.vibration(handout, psd, 0.01, **shaken)
    with pytest.warns(UserWarning, match=r"^thresholds: .*, most of it at f0 = 1500 Hz"):
        snapmap.design(handout, "thickness", **SINGLE, between=(2.0, 2.2), **CHEAP)
    with pytest.warns(UserWarning, match=r"^simulate: .*, most of it at f0 = 1500 Hz"):
        snapmap.simulate(handout, **SINGLE, **CHEAP)
    with pytest.raises(ValueError, match=r"^simulate: .*; write a higher f0 or a shorter horizon"):
        snapmap.simulate(handout, **SINGLE, **CHEAP | {"horizon": 1e300})
    monkeypatch.setattr("snapmap.solver.cost.MOST_SECONDS", 0.0)
    with pytest.raises(ValueError, match=r"^vibration: .*; write a higher lowest frequency"):
        snapmap.vibration(handout, psd, 0.01, **shaken)


def test_what_is_hardly_meant_is_told(handout):
    with pytest.warns(
        UserWarning, match="^C = 100000 .* times critical damping; is its unit right"
    ):
        snapmap.sweep(handout, 1000.0, 1500.0, 1e5, **CHEAP)
    with pytest.warns(
        UserWarning, match=r"^N = 1000000000 is outside the usual 0 to 1000000; is its"
    ):
        snapmap.sweep(handout, 1e9, 1500.0, 1.0, **CHEAP)


def test_more_cells_than_a_call_can_hold_are_refused(handout):
    with pytest.raises(ValueError, match=r"^N: 1e\+11 "):
        snapmap.sweep(handout, np.arange(1e5), np.arange(1.0, 1e4 + 1), np.arange(100.0))


# Numbers of numpy's and xarray's: each is one of Python's behind the door.
WHOLE = (np.int64, np.int32, lambda number: np.array(int(number)))
KINDS = (*WHOLE, np.float32, np.float64, np.array, xr.DataArray)
SEVERAL = (np.array, xr.DataArray, tuple, lambda row: [*map(np.float32, row)])
EXACT = {
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


def arguments_of(name):
    """What a function takes, with its options and those of its models."""
    named = parameters_of(name)
    arguments = {key: argument_of(named[key].annotation) for key in named if key != "options"}
    return (OF_MODEL if "model" in named else {}) | arguments | options_of(FUNCTIONS[name])


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


@pytest.mark.parametrize("name", [name for name in VERBS if name != "reference"])  # of functions
def test_each_numeric_argument_of_each_function_takes_each_kind(name):
    arguments = arguments_of(name)
    for key in arguments.keys() - NO_NUMBERS:
        right = EXACT.get(key, 2.0)
        for value in kinds_of(right):
            behind = arguments[key].take(key, value)
            if isinstance(behind, np.ndarray):
                assert behind.dtype == float and type(behind) is np.ndarray
                behind = behind.tolist() if np.ndim(right) else behind.item()
            assert json.loads(json.dumps(behind)) == right, (key, value)
            assert type(behind) is type(right), (key, value)


def test_a_row_is_an_array_of_floats():
    for row in kinds_of([500.0, 1500.0]):
        behind = arguments_of("sweep")["f0"].take("f0", row)
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
    plain = {**SINGLE, **CHEAP}
    other = plain | {key: kind(plain[key]) for key in (*SINGLE, "horizon")} | {"modes": np.int64(3)}
    run = snapmap.simulate(handout, **other)
    assert run.identical(snapmap.simulate(handout, **plain))
    cube = snapmap.sweep(handout, **other, until="snap", energy_tolerance=np.float32(0.25))
    assert cube.identical(snapmap.sweep(handout, **plain, until="snap", energy_tolerance=0.25))
    for made in (run, cube):
        assert "np." not in made.attrs["config"] and json.loads(made.attrs["config"])
