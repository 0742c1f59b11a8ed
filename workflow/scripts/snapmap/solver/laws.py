"""A user's own laws: functions in place of forces of the model."""

import inspect
import os
import re
import sysconfig
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated

import numpy as np

from ..files.named import inside, naming, read_named, sha256_of
from ..files.text import show
from ..values.arguments import Argument, Reading, convert
from ..values.faults import Faults, within
from ..values.kinds import ANYTHING, Kind, Number
from ..values.quantities import Value
from ..values.units import OF_DAMPER, require_unit

PARAMETERS = {
    "damping": ("C", "velocity", "place"),
    "contact": ("stiffness", "overlap"),
    "force": ("displacement",),
}
"""Parameters of each law, in this order and under any names; units: docs/own-physics.md."""
LAWS = 100_000, "write the laws alone"
"""Most bytes of a file of laws, and the remedy for a larger one."""

UNIT = "unit_of_C"
"""Name, beside the laws, of the unit in which the damping counts C."""
MODULE = "laws_of_a_study"
"""Name of the module of a file of laws: numba would take that of another one for it."""
_FOLDERS = Path(__file__).parents[1], *map(sysconfig.get_path, ("stdlib", "purelib"))
LIBRARIES = tuple(f"{folder}{os.sep}" for folder in _FOLDERS)
"""Folders whose lines are no user's."""
OF_NUMBA = r'During: |File "|There are \d+ candidate'
"""Where in an error of numba that begins which only numba's own authors need."""
REACH, POINTS = 10.0, 10_000
"""Range over the rise in which a law is sampled, and number of samples on either side of 0."""


@dataclass(frozen=True)
class Laws:
    """Compiled functions, as `reference` takes them; None where the device's force acts.

    file, sha256: of the functions, if they were read from one
    unit_of_C: as a config spells it; "" for a plain number
    """

    damping: Callable | None = None
    contact: Callable | None = None
    force: Callable | None = None
    file: str = ""
    sha256: str = ""
    unit_of_C: str = OF_DAMPER

    def __str__(self):
        """Name the file, or the functions, as in attributes of products."""
        if self.file:
            return self.file
        laws = ((key, law) for key in PARAMETERS if (law := getattr(self, key)))
        return ", ".join(f"{key}: {getattr(law, '__name__', key)}" for key, law in laws)


def compile_laws(functions: Mapping[str, object]) -> Laws:
    """Compile functions by the names of their laws; raises ValueError, one line, for wrong ones."""
    laws = {key: _compiled(key, functions[key]) for key in PARAMETERS if functions.get(key)}
    if not laws:
        needs = " or ".join(PARAMETERS)
        raise ValueError(f"model.laws: no law; write a function named {needs}")
    if UNIT in functions and "damping" not in laws:
        raise ValueError(f"model.laws: {UNIT}: needs a law of damping; leave it out")
    with naming(f"model.laws: {UNIT}"):
        return Laws(**laws, unit_of_C=require_unit(functions.get(UNIT, OF_DAMPER)))


@contextmanager
def of_user(what: str, law: object = None) -> Iterator[None]:
    """Turn any error of a user's code into a ValueError, one line that begins with model.laws.

    what: the file or law that runs; law: its function, if there is one
    The line names the file and the line of the error, or else those where the law begins.
    """
    try:
        yield
    except (Exception, SystemExit) as error:
        from numba.core.errors import NumbaError

        place = _line_of(error)
        told = error.msg if isinstance(error, SyntaxError) else str(error)
        fault = f"{type(error).__name__}: {told}"
        if isinstance(error, NumbaError):
            told = re.sub(r"^Failed in .*?\(step: .*?\)", "", told, flags=re.DOTALL)
            fault = f"numba cannot compile it; {re.split(OF_NUMBA, told)[0]}"
        what = "" if place and what == place[0] else f"{what}: "
        line = " ".join(f"{_at(place, law)}{what}{fault}".split())
        raise ValueError(f"model.laws: {line.removesuffix(':')}") from error


def _line_of(error):
    """Find the file and line of a user's code in which an error arose; None if none is known."""
    if isinstance(error, SyntaxError) and error.lineno:
        return error.filename, error.lineno
    frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    for places in (frames, re.findall(r'File "(.*?)", line (\d+)', str(error))):
        if own := [at for at in places if not os.path.abspath(at[0]).startswith(LIBRARIES)]:
            return own[-1]
    return None


def _at(place, law=None):
    """Write file and line before a fault, or those where a law begins; a notebook has no file."""
    law = getattr(law, "func", law)
    code = getattr(getattr(law, "py_func", law), "__code__", None)
    if not (place or code):
        return ""
    file, line = place or (code.co_filename, code.co_firstlineno)
    return f"{file}, line {line}: " if Path(file).is_file() else f"line {line}: "


def fault_of(law: Callable, key: str, line: str) -> ValueError:
    """Make the error of a law that is wrong, by its name: a line with the file and line of it."""
    return ValueError(f"model.laws: {_at(None, law)}{key}: {line}")


@cache
def load_laws(path: str, sha256: str = "") -> Laws:
    """Run a Python file and compile its laws; raises ValueError, one line with the path.

    sha256: expected hash of the file, hex digits; empty for any
    """
    with naming(f"model.laws: {path}"):
        content = read_named(path, *LAWS, sha256)
    names = {"__name__": MODULE}
    with of_user(path):
        exec(compile(content, path, "exec"), names)
    try:
        return replace(compile_laws(names), file=path, sha256=sha256)
    except ValueError as error:
        line = str(error).removeprefix("model.laws: ")
        line = line if line.startswith(f"{path}, line ") else f"{path}: {line}"
        raise ValueError(f"model.laws: {line}") from error.__cause__


class LawsKind(Kind):
    """Laws: what `compile_laws` makes, or the path of a Python file that has them."""

    need = "the path of a Python file with laws, or functions by name"
    asks = "the path of a Python file in the study's folder"
    type = str | Mapping[str, Callable]

    def convert(self, value: object, reading: Reading) -> Laws:
        """Take laws, or read a file, of a config one in the study's folder."""
        if isinstance(value, Laws):
            return value
        is_mapping = isinstance(value, Mapping) and not reading.written
        functions = _of_names(value) if is_mapping else {}
        try:
            if functions:
                return compile_laws(functions)
            if isinstance(value, str) and value:
                path = inside(value) if reading.written else value
                return load_laws(path, sha256_of(path, *LAWS))
        except ValueError as error:
            raise ValueError(str(error).removeprefix("model.laws: ")) from error
        raise self.refuse(value, reading)

    def schema(self) -> dict:
        """Describe a path."""
        return {"type": "string"}


def _of_names(functions):
    """Refuse functions that are no laws."""
    known = dict.fromkeys([*PARAMETERS, UNIT], Argument(ANYTHING, is_optional=True))
    try:
        return convert(known, functions, unknown="is not a law")
    except Faults as faults:
        raise Faults(*map(within, faults.args)) from None


UserLaws = Annotated[Value, LawsKind()]


def _compiled(key, law):
    """Compile a law, and check its parameters, its result and the sign of a damping."""
    from numba import njit

    function, needs = getattr(law, "py_func", law), PARAMETERS[key]
    if not inspect.isfunction(function):
        raise ValueError(f"model.laws: {key}: is not a function; write a def or a lambda")
    with of_user(key):
        parameters = inspect.signature(function).parameters
    if len(parameters) != len(needs):
        line = f"takes ({', '.join(parameters)}); write ({', '.join(needs)})"
        raise fault_of(law, key, line)
    law = law if law is not function else njit(error_model="numpy")(function)
    with of_user(key, law):
        value = law(*np.full(len(needs), 0.25))
    if not isinstance(value, float):
        raise fault_of(law, key, f"returns {show(value)}; return a float")
    if key == "damping":
        with of_user(key, law):
            drives = any(v * law(1.0, v, z) < 0 for v in (-1.0, 1.0) for z in (-1.0, 1.0))
        if drives:
            raise fault_of(law, key, "drives the mass; give it the sign of the velocity")
    return law


def well_of(force: Callable, rise: Number) -> tuple[float, float, float]:
    """Find saddle and second shape, um, and the energy of the saddle, pJ, of a double well.

    The energy is the integral of the force. Raises ValueError if this has no double well.
    """
    x, F = curve("force", force, rise)
    falls, rises = (np.flatnonzero((s * F[:-1] > 0) & (s * F[1:] <= 0)) for s in (1.0, -1.0))
    falls, rises = falls[falls > POINTS], rises[rises > POINTS]
    rises = rises[rises > falls[0]] if falls.size else falls
    least = 1e-9 * abs(F).max()
    if abs(F[POINTS]) > least or F[:POINTS].max() > least or not rises.size:
        needs = "0 at 0, then positive, negative from a saddle on, and positive again"
        needs += f" below {x[-1]:g} um, and nowhere positive below 0"
        raise fault_of(force, "force", f"no two stable shapes; make it {needs}")
    step, i, j = x[POINTS + 1], falls[0], rises[0]
    saddle, second = (float(x[k] + step * F[k] / (F[k] - F[k + 1])) for k in (i, j))
    energy = step * (F[POINTS:i].sum() + F[i] / 2) + F[i] * (saddle - x[i]) / 2
    return saddle, second, float(energy)


def curve(name: str, law: Callable, rise: Number) -> tuple[np.ndarray, np.ndarray]:
    """Sample a law of one displacement: places, um, up to REACH times the rise, and forces, uN."""
    x = REACH * float(np.max(rise)) / POINTS * np.arange(-POINTS, POINTS + 1)
    return x, forces(name, law, x)


def forces(name: str, law: Callable, x: np.ndarray) -> np.ndarray:
    """Ask a law of one displacement for its forces, uN, at places, um, (n,)."""
    with of_user(name, law):
        return np.array([law(place) for place in x.tolist()])
