"""Types of the arguments and options that several public functions share, for their signatures.

Each type carries its `Argument`: words that say what would be right, the test whether a value fits,
and its conversion, by which numbers of numpy or xarray become Python's. Values of the device, N, f0
and C have units and ranges of `quantities.csv`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Annotated, TypedDict

import numpy as np

from ..device.argument import Argument, Flag, integer, is_flag, is_list, number, of_type, row, word
from ..device.device import VALUES, Device
from ..device.quantities import QUANTITIES, Bounds, bounds_of
from ..pulse.pulse import DIRECTIONS, SHAPES, Pulse
from ..solver.laws import compile_laws
from ..solver.options import OPTIONS, ModelOptions
from ..solver.settings import FIRST, STARTS, UNTIL
from .study import ANY, ARRIVES


def _is_device(value):
    if not isinstance(value, Device):
        return False
    parts = (value, value.beam)
    return not any(np.ndim(getattr(part, field.name)) for part in parts for field in fields(part))


def _are_devices(value):
    named = value.values() if isinstance(value, Mapping) and value else [value]
    return all(map(_is_device, named))


def _is_model(value):
    if isinstance(value, str):
        return value in OPTIONS
    return isinstance(value, Mapping) or callable(value)


def _is_pulse(value):
    if isinstance(value, str):
        return value in SHAPES
    return isinstance(value, Pulse) or (isinstance(value, Mapping | list | tuple) and bool(value))


def _are_directions(value):
    if isinstance(value, str):
        return value in (*DIRECTIONS, "both")
    named = is_list(value, lambda name: isinstance(name, str) and name in DIRECTIONS)
    return named and 0 < len(value) == len({*value})


def _is_requirement(value):
    return (
        isinstance(value, Mapping)
        and _REQUIRED.keys() <= value.keys()
        and all(kind.fits(value[key]) for key, kind in _REQUIRED.items())
        and _START.fits(value.get("start", FIRST))
    )


def _model_of(value):
    """Make a model of a user's own solver; others stay as they are."""
    if callable(value):
        return {"name": "reference", "laws": compile_laws({"solver": value})}
    return value


def _requirement(value):
    return {**value, **{key: kind.convert(value[key]) for key, kind in _REQUIRED.items()}}


def _of(key: str) -> tuple[Bounds, str]:
    return QUANTITIES[key].range, QUANTITIES[key].unit


_N = bounds_of("[0, inf)"), "multiples of g (direction -z pushes the other way)"
Amplitudes = Annotated[float | Sequence[float], row(*_N, "[1000]")]
Amplitude = Annotated[float, number(*_N, "1000")]
Frequencies = Annotated[float | Sequence[float], row(*_of("f0"), "[1500]")]
Frequency = Annotated[float, number(*_of("f0"), "1500")]
Dampers = Annotated[float | Sequence[float], row(*_of("C"), "[25]")]
Damper = Annotated[float, number(*_of("C"), "25")]
Devices = Annotated[
    Device | Mapping[str, Device],
    Argument(
        "a Device, or several by name, each value a number; load_device reads one", _are_devices
    ),
]
SingleDevice = Annotated[
    Device, Argument("a single Device, each value a number; load_device reads one", _is_device)
]
Model = Annotated[
    str | Mapping | Callable,
    Argument(
        f"one of {', '.join(OPTIONS)}, or what reference makes, or a solver of your own",
        _is_model,
        _model_of,
    ),
]
Horizon = Annotated[float, number("[0, inf)", "us", "1500")]
EnergyTolerance = Annotated[float, number("(0, 1)", "", "1e-3")]
Threads = Annotated[int, integer(1, 1024)]
Until = Annotated[str, word(*UNTIL)]
_START = word(*STARTS)
Start = Annotated[str, _START]
Seed = Annotated[int, integer(0, 2**32 - 1)]
PulseSpec = Annotated[
    str | Pulse | Mapping | Sequence,
    Argument(f"one of {', '.join(SHAPES)}, or what sampled or read_pulse makes", _is_pulse),
]
Directions = Annotated[
    str | Sequence[str], Argument("+z, -z, both, or a list of these", _are_directions)
]
Direction = Annotated[str, word(*DIRECTIONS)]
Refinement = Annotated[float, number("[1e-9, 0.01]", "", "1e-4")]
_TRIPS = Argument(
    'True, False, "arrives" or "any"',
    lambda value: is_flag(value) or (isinstance(value, str) and value in (ANY, ARRIVES)),
    lambda value: value if isinstance(value, str) else bool(value),
)
_POSITIVE = number("(0, inf)")
_REQUIRED = {"name": of_type("a name", str), "N": _POSITIVE, "f0": _POSITIVE, "snaps": _TRIPS}
Requirements = Annotated[
    Sequence[Mapping],
    Argument(
        'a list of mappings of name, N, f0 (Hz) and snaps (True, False, "arrives" or "any")',
        lambda value: is_list(value, _is_requirement),
        lambda value: [*map(_requirement, value)],
    ),
]


class RunOptions(ModelOptions, total=False):
    """Options on how each cell is followed."""

    horizon: Horizon
    energy_tolerance: EnergyTolerance
    threads: Threads


class ThresholdOptions(RunOptions, total=False):
    """Options on how each cell is followed, from which shape, and under which shocks."""

    start: Start
    pulse: PulseSpec
    direction: Directions


_OF_DEVICE = {key: Annotated[float | Sequence[float], row(*_of(key), "")] for key in VALUES}
_Axes = TypedDict("_Axes", _OF_DEVICE, total=False)


class AxisOptions(_Axes, total=False):
    """Options: values of the device as axes; skip leaves out points without a second shape."""

    skip: Flag
