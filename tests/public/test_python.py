"""The functions of the package: what there is, what they take, and what a wrong call says."""

import doctest
import inspect
import itertools
import json
import pickle
import random
from dataclasses import fields, replace
from typing import get_args

import numpy as np
import pint
import pytest
import xarray as xr
from small_studies import cases_of

import snapmap
from snapmap.device.device import Beam, Device, batch
from snapmap.pulse.shocks import make_shocks

CASES = cases_of(__file__)
SINGLE = {"N": 1000.0, "f0": 1500.0, "C": 25.0}
CHEAP = {"model": snapmap.Cosines(modes=3), "horizon": 0.0}
DEVICE = Device(Beam(600.0, 10.0, 2.0, 22.0, 150e3, 2.33e-3), 1e4, 5.5, 40.0, 9.81e-6)
SHOTS = {"N": [800, 900, 950, 1000], "tripped": [False] * 2 + [True] * 2, "duration": [1000.0] * 4}
WRONG = (
    *(None, "abc", "1500 Hz", "", b"abc", "a\nb", np.nan, np.inf, -np.inf, -1.0, 0.5j, 10**400),
    *([], (), {}, [[]], [[1.0], [2.0, 3.0]], [[[1.0]]], ["abc"], [None], [np.nan], [-1.0]),
    *({"name": []}, [[1.0]], [memoryview(b"a")], batch([DEVICE, DEVICE])),
    *("25 cd", xr.DataArray(1.0, attrs={"units": "cd"}), [1.0, 2.0] * pint.Unit("cd")),
    *({"abc": 1}, {1: [2]}, {"N": "abc"}, {1.0, 2.0}, object(), object, len, range(0), ...),
    *(np.ones(100_000), np.array(["abc"]), np.array(None), np.zeros((2, 3, 4)), "abc" * 10_000),
)
"""Right for no argument but those of `RIGHT`."""
RIGHT = {
    **{"sha256": ("",), "requirements": ([], ()), "together": ([], (), [[]]), "axes": ({},)},
    **{"f0": ("1500 Hz",), "pulse": ({},)},
    "source": [value for value in WRONG if isinstance(value, dict)],  # a line for each fault of it
}


def is_right(key, value):
    return any(type(one) is type(value) and one == value for one in RIGHT.get(key, ()))


FUNCTIONS = {name: getattr(snapmap, name) for name in snapmap.__all__}


def test_a_device_of_several_values_is_told_what_it_lacks():
    for wrong in (replace(DEVICE, mass=[1e4, 2e4]), {"a": DEVICE, "b": batch([DEVICE])}):
        for call in (snapmap.statics, snapmap.Study):
            with pytest.raises(ValueError, match=r"\A(study|device): .* is not a .*load_device"):
                call(wrong)
    with pytest.raises(ValueError, match="a Device is not a Device of single values"):
        snapmap.Study(replace(DEVICE, mass=[1e4, 2e4]))


def parameters_of(name):
    return inspect.signature(FUNCTIONS[name]).parameters


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_example_of_each_function_is_true(root, monkeypatch, name):
    monkeypatch.chdir(root)
    finder = doctest.DocTestFinder(recurse=False)
    (example,) = finder.find(FUNCTIONS[name], name, globs={"snapmap": snapmap})
    assert example.examples and doctest.DocTestRunner().run(example).failed == 0


def values_of(record):
    return {field.name: getattr(record, field.name) for field in fields(record)}


@pytest.fixture(scope="module")
def right_calls(handout, root):
    """A right call of each function."""
    study = snapmap.Study(handout, **CHEAP)
    cube = snapmap.sweep(study, [900.0, 1000.0], [1500.0], [25.0])
    at = {"study": study}
    several = {**at, **{key: [SINGLE[key]] for key in SINGLE}}
    no_N = {key: several[key] for key in several if key != "N"}
    no_f0 = {key: no_N[key] for key in no_N if key != "f0"}
    pairs, axes = [(500, 700), (2000, 1500)], {"axes": {"thickness": [2.0]}}
    return {
        **{type(part).__name__: values_of(part) for part in (DEVICE, DEVICE.beam)},
        "calibrate": {**at, "shots": SHOTS, "unknowns": {"thickness": (1.7, 2.3)}, "C": 25.0},
        "design": {**at, "value": "thickness", **SINGLE, "between": (1.8, 2.2)},
        "load_device": {"source": root / "config/config.yaml"},
        "open_cube": {"path": root / "no.nc"},
        "plot_outcome": {"cube": cube, "ax": None, "x": "f0", "y": "N", "ends": False},
        "read_pulse": {"path": root / "config/half_sine.csv", "sha256": ""},
        "simulate": {**at, **SINGLE},
        "srs_test": {**no_f0, "srs": pairs, "records": 1, "seed": 1, **axes},
        "statics": at,
        "sweep": {**several, **axes},
        "threshold": {**no_N, "tolerance": 1e-3, "highest": 2000.0, **axes},
        "tolerance": {
            **{**several, "scatters": {"thickness": "5 %"}, "threshold_tolerance": 1e-3},
            **{"samples": 8, "seed": 1},
        },
        "vibration": {**no_f0, "psd": pairs, "duration": 0.01, "records": 1, "seed": 1, **axes},
        "words": {"variable": cube.outcome},
    }


def wrong_calls(right_calls):
    """Each function with each argument, one at a time, as each of WRONG."""
    for name, right in right_calls.items():
        parameters = {} if name in ("Beam", "Device") else parameters_of(name)
        for key, value in itertools.product(parameters, WRONG):
            annotation = parameters[key].annotation
            optional = type(None) in get_args(annotation)
            if not is_right(key, value) and not (value is None and optional):
                yield name, right, key, value


NESTED = CASES["nested"] | {"unknowns": [{"thickness": (1.7, 2.3)}]}
NESTED["shots"] = [{**SHOTS, "direction": ["+z"] * 4, "shape": ["half sine"] * 4}]
"""Right values of which a part can be wrong."""


def wrong_parts(value):
    """The value, each of its parts, however deep, as each of WRONG."""
    places = {0, len(value) - 1} if isinstance(value, list) else ()
    for key in value if isinstance(value, dict) else places:
        for part in (*WRONG, *wrong_parts(value[key])):
            changed = value.copy()
            changed[key] = part
            yield changed


def nested_wrong_calls(right_calls):
    """Each function with each part of its arguments that have some as each of WRONG."""
    for name, right in right_calls.items():
        for key in NESTED.keys() & parameters_of(name):
            for value in itertools.chain.from_iterable(map(wrong_parts, NESTED[key])):
                yield name, right, key, value


def fault_of(name, arguments, key):
    """What is wrong with the complaint about a wrong argument, or nothing."""
    try:
        FUNCTIONS[name](**arguments)
    except (ValueError, TypeError) as fault:
        text = str(fault)
        right = key, "tolerances.", str(arguments[key])
        clear = (line.startswith(right) and len(line) < 200 for line in text.split("\n"))
        return "" if all(clear) else text
    except Exception as fault:
        return repr(fault)[:200]
    return "passes"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("stride", [3, pytest.param(1, marks=pytest.mark.long)])
def test_a_wrong_argument_is_one_line_that_names_it(right_calls, stride):
    every = [*wrong_calls(right_calls), *nested_wrong_calls(right_calls)][::stride]
    faults = {}
    for name, right, key, value in every:
        if fault := fault_of(name, {**right, key: value}, key):
            faults[name, key, repr(value)[:30]] = fault
    # A few of these are right in their place, as is a cell of shots that is empty.
    unclear = {call: fault for call, fault in faults.items() if fault != "passes"}
    assert len(unclear) <= 4, unclear
    assert len(faults) <= 49, faults


def test_a_value_just_beyond_the_right_ones_is_one_line_that_names_it(right_calls):
    for name, key, value in CASES["beyond"]:
        assert fault_of(name, {**right_calls[name], key: value}, key) == "", (name, key)


def test_a_wrong_value_of_a_study_is_one_line_that_names_it():
    every = itertools.product(("device", "pulse", "horizon", "skip"), WRONG)
    for key, value in [*CASES["of_study"], *(one for one in every if not is_right(*one))]:
        with pytest.raises((ValueError, TypeError)) as caught:
            snapmap.Study(**{"device": DEVICE, key: value})
        line = str(caught.value)
        assert line.startswith(key) and "\n" not in line and len(line) < 200, (key, value, line)


def test_a_misspelt_argument_is_named_with_the_right(right_calls):
    rng = random.Random(2)
    for name, right in right_calls.items():
        for key in sorted(parameters_of(name).keys() - {"N", "C", "f0", "x", "y", "ax"}):
            at = rng.randrange(1, len(key.rstrip("2345")))  # cosine_ is like all four of them
            wrong = key[:at] + key[at + 1 :]
            line = rf"(?m)^{wrong}: is not an argument; did you mean {key}"
            with pytest.raises(TypeError, match=line):
                FUNCTIONS[name](**right, **{wrong: 1})
            turned = key[: at - 1] + key[at] + key[at - 1] + key[at + 1 :]
            if turned != key and len(key) > 4:
                with pytest.raises(TypeError, match=rf"(?m)^{turned}: .*; did you mean {key}"):
                    FUNCTIONS[name](**right, **{turned: 1})


def test_what_belongs_elsewhere_is_told_where(right_calls):
    for key, words in CASES["elsewhere"].items():
        with pytest.raises(TypeError, match=f"^{key}: is not an argument{words}"):
            snapmap.sweep(**right_calls["sweep"], **{key: 1})


def test_a_duration_stands_for_f0_in_every_call_and_beside_it_in_none(handout):
    study = snapmap.Study(handout, "3 cosines", horizon=0)
    drop = {"name": "drop", "N": 900.0, "snaps": False}
    for name, values in CASES["timed"].items():
        made = FUNCTIONS[name](study, duration="0.4 ms", **values)
        assert made.identical(FUNCTIONS[name](study, f0=2500.0, **values))
        with pytest.raises(ValueError, match=r"\Aduration: excludes f0, .*; write one of them\Z"):
            FUNCTIONS[name](study, f0=2500.0, duration=400.0, **values)
        with pytest.raises(TypeError, match=r"\Af0: missing; write f0 or duration\Z"):
            FUNCTIONS[name](study, **values)
    of_both = [
        snapmap.design(study, "C", between=(10, 400), requirements=[drop | time]).low.values
        for time in ({"duration": 400.0}, {"f0": "2.5 kHz"})
    ]
    np.testing.assert_array_equal(*of_both)


def test_all_faults_of_a_call_are_told_at_once(handout):
    with pytest.raises(ValueError) as caught:
        snapmap.threshold(handout, -1.0, "25 kg", tolerance=1.0, axes={"rise": "a"})
    keys = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert keys == ["f0", "C", "tolerance", "axes.rise"]
    with pytest.raises(TypeError) as caught:
        snapmap.sweep(handout, tolerance=1e-3)
    assert [line.split(":")[0] for line in str(caught.value).splitlines()] == [
        *("f0", "tolerance", "N", "C")
    ]


def test_what_is_missing_or_there_twice_or_too_much_is_named(right_calls):
    for name, right in right_calls.items():
        parameters = parameters_of(name)
        for key in parameters:
            if parameters[key].default is inspect.Parameter.empty:
                with pytest.raises(TypeError, match=f"^{key}: missing; write "):
                    FUNCTIONS[name](**{other: right[other] for other in right if other != key})
        first = next(iter(parameters))
        with pytest.raises(TypeError, match=f"^{first}: comes twice"):
            FUNCTIONS[name](right[first], **right)
        most = sum(part.kind is not part.KEYWORD_ONLY for part in parameters.values())
        takes = f"^{name}: takes {most} arguments without a name, not {most + 1}"
        with pytest.raises(TypeError, match=takes):
            FUNCTIONS[name](*range(most + 1))


def test_functions_can_be_sent_to_other_processes():
    for function in FUNCTIONS.values():
        assert pickle.loads(pickle.dumps(function)) is function


def test_a_map_has_two_axes(right_calls):
    cube = right_calls["plot_outcome"]["cube"]
    for x, y in (("N", "N"), ("f0", "duration")):
        with pytest.raises(ValueError, match=f"^x: '{x}' is already y"):
            snapmap.plot_outcome(cube, x=x, y=y)


def test_what_takes_long_is_told_before_it_begins(handout, monkeypatch):
    monkeypatch.setattr("snapmap.solver.cost.WORTH_SAYING", 0.0)
    study, shaken = snapmap.Study(handout, **CHEAP), {"C": [25.0], "records": 1}
    psd, srs = [(200, 4.0), (2000, 4.0)], [(500, 700), (2000, 1500)]
    with pytest.warns(UserWarning, match=r"^srs_test: .*, most of it at a record of"):
        snapmap.srs_test(study, srs, **shaken)
    with pytest.warns(UserWarning, match=r"^vibration: .*, most of it at a record of"):
        snapmap.vibration(study, psd, 0.01, **shaken)
    with pytest.warns(UserWarning, match=r"^thresholds: .*, most of it at f0 = 1500 Hz") as told:
        snapmap.design(study, "thickness", **SINGLE, between=(2.0, 2.2))
        exec("snapmap.threshold(study, 1500.0, 25.0)", {"snapmap": snapmap, "study": study})
    assert {each.filename for each in told} == {__file__, "<string>"}
    with pytest.warns(UserWarning, match=r"^simulate: .*, most of it at f0 = 1500 Hz"):
        snapmap.simulate(study, **SINGLE)
    with pytest.raises(ValueError, match=r"^simulate: .*; write a higher f0 or a shorter horizon"):
        snapmap.simulate(replace(study, horizon=1e300), **SINGLE)
    monkeypatch.setattr("snapmap.solver.cost.MOST_SECONDS", 0.0)
    with pytest.raises(ValueError, match=r"^vibration: .*; write a higher lowest frequency"):
        snapmap.vibration(study, psd, 0.01, **shaken)


def test_what_is_hardly_meant_is_told(handout):
    study = snapmap.Study(handout, **CHEAP)
    with pytest.warns(
        UserWarning, match="^C = 100000 .* times critical damping; is its unit right"
    ):
        snapmap.sweep(study, 1000.0, 1500.0, 1e5)
    with pytest.warns(
        UserWarning, match=r"^N = 1000000000 is outside the usual 0 to 1000000; is its"
    ):
        snapmap.sweep(study, 1e9, 1500.0, 1.0)
    flat = snapmap.sampled([0.0, 99.0, *range(300, 309), 400.0], [0.0, *[1.0] * 10, 0.0], "top")
    with pytest.warns(UserWarning, match="^top: is flat at its peak for 0.21 ms"):
        snapmap.sweep(snapmap.Study(handout, pulse=flat, **CHEAP), 100.0, None, 25.0)


def test_more_cells_than_a_call_can_hold_are_refused(handout):
    with pytest.raises(ValueError, match=r"^N: 1e\+11 "):
        snapmap.sweep(handout, np.arange(1e5), np.arange(1.0, 1e4 + 1), np.arange(100.0))


def converted(value, kind):
    """The value with each of its numbers that another kind holds as that kind."""
    if isinstance(value, dict):
        return {key: converted(inner, kind) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [converted(inner, kind) for inner in value]
    if type(value) not in (int, float) or not np.isfinite(value):
        return value
    made = kind(value)
    is_held = float(made) == value and (type(value) is float or made.dtype == int)
    return made if is_held else value


def test_numbers_of_pulses_are_plain():
    whole, part = np.int64(2), np.float32(0.5)
    train = [{"duration": whole, "N": part}, {"wait": xr.DataArray(5)}, {"repeat": whole}]
    drop = {"height": np.array(1e6), "duration": np.int64(500), "rebound": part}
    trapezoid = {"shape": "trapezoid", "rise": part, "fall": np.float64(0.25)}
    for pulse in ({"train": train}, {"drop": drop}, trapezoid):
        section = make_shocks(pulse).section()
        assert json.loads(json.dumps(section)) == section and "np." not in str(section)


def test_calls_give_the_same_by_numbers_of_each_kind(handout, right_calls):
    """Those of numpy and xarray are plain ones behind the door."""
    kinds = np.float64, np.float32, np.int64, np.array, xr.DataArray
    for kind in kinds:
        study = snapmap.Study(handout, snapmap.Cosines(modes=np.int64(3)), horizon=kind(0.0))
        assert study == snapmap.Study(handout, **CHEAP)
    for name in right_calls.keys() - {"load_device", "open_cube", "plot_outcome", "words"}:
        made = FUNCTIONS[name](**right_calls[name])
        for kind in kinds:
            other = FUNCTIONS[name](**converted(right_calls[name], kind))
            if name in ("design", "read_pulse", "Beam", "Device"):
                assert made == other, (name, kind)
            else:
                assert made.identical(other) and "np." not in other.attrs["config"], (name, kind)


def test_coordinates_of_its_own_cubes_are_taken(handout):
    study = snapmap.Study(handout, **CHEAP)
    cube = snapmap.sweep(study, [900.0, 1000.0], [1500.0], [25.0], axes={"thickness": [2.0]})
    assert (cube.f0.units, cube.C.units, cube.thickness.units) == ("Hz", "uN us um-1", "um")
    axes = {"thickness": cube.thickness}
    edges = snapmap.threshold(study, cube.f0, cube.C, axes=axes)
    assert edges.N_first.units == "1"
    again = snapmap.sweep(study, cube.N, cube.f0, cube.C, axes=axes)
    xr.testing.assert_identical(again.t_snap, cube.t_snap)
    run = snapmap.simulate(study, edges.N_first.item() * 1.1, 1500.0, 25.0)
    assert snapmap.sampled(run.time, -run.acceleration + run.acceleration[0]).duration > 600
    assert snapmap.threshold(study, xr.DataArray([1500.0]), 25.0).N_first.notnull().all()
