"""Calls are held to the kinds of their signatures: each wrong argument is a line, all at once."""

from contextlib import contextmanager, nullcontext

import pytest

from snapmap.values.calls import checked
from snapmap.values.faults import Faults
from snapmap.values.quantities import Dampers, Length, Mass, Modes


def beam(span: Length, mass: Mass, *, modes: Modes | None = None, C: Dampers = (1.0,)):
    """Give what a call hands over."""
    return span, mass, modes, C


@pytest.fixture
def prepared():
    """The arguments that `prepare` was given, by call."""
    return []


@pytest.fixture
def call(prepared):
    @contextmanager
    def prepare(function, values):
        prepared.append((function, values))
        yield

    return checked(beam, {"horizon": "; write run={'horizon': ...}"}, prepare, nullcontext)


def test_arguments_are_converted_by_their_kinds_and_defaults_stay(call, prepared):
    assert call("1 mm", mass=2.0) == (1000.0, 2.0, None, (1.0,))
    assert prepared == [(beam, {"span": 1000.0, "mass": 2.0})]
    *_, modes, C = call(1.0, "none", modes=None, C=["25 uN*us/um", 3.0])
    assert modes is None and C.tolist() == [25.0, 3.0]
    assert call.__name__ == "beam" and call.__doc__ == beam.__doc__


def test_all_wrong_values_are_told_at_once_before_anything_runs(call, prepared):
    with pytest.raises(Faults) as caught:
        call(-1.0, "3 kHz", modes=0, C=[])
    lines = caught.value.args
    assert [line.partition(":")[0] for line in lines] == ["span", "mass", "modes", "C"]
    assert str(caught.value) == "\n".join(lines) and not prepared


WRONG = (
    ((), {}, ["span: missing; write a number above 0 in um", "mass: missing; write a number"]),
    ((1.0,), {"span": 2.0, "mass": 1.0}, ["span: comes twice; write it once"]),
    ((1.0, 2.0, 3.0), {}, ["beam: takes 2 arguments without a name, not 3"]),
    ((1.0, 2.0), {"mode": 3}, ["mode: is not an argument; did you mean modes?"]),
    ((1.0,), {"masss": 3}, ["masss: is not an argument; did you mean mass?", "mass: missing"]),
    ((1.0, 2.0), {"modse": 3}, ["modse: is not an argument; did you mean modes?"]),
    ((1.0, 2.0), {"xyz": 3}, ["xyz: is not an argument of beam"]),
    ((1.0, 2.0), {"horizon": 3}, ["horizon: is not an argument; write run={'horizon': ...}"]),
    ((1.0, 2.0), {"horizn": 3}, ["horizn: is not an argument; did you mean horizon?"]),
)


@pytest.mark.parametrize(("positional", "named", "lines"), WRONG)
def test_what_is_missing_twice_misspelt_or_elsewhere_is_a_line(
    call, prepared, positional, named, lines
):
    with pytest.raises(TypeError) as caught:
        call(*positional, **named)
    told = str(caught.value).splitlines()
    assert len(told) == len(lines) and not prepared
    for line, begin in zip(told, lines, strict=True):
        assert line.startswith(begin)
