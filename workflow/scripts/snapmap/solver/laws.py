"""Laws of a user's own in the place of three forces of the model `reference`."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated

import numpy as np

from ..device.argument import Argument
from ..device.device import Value
from ..files.named import naming, read_named

PARAMETERS = {
    "damping": ("C", "velocity", "place"),
    "contact": ("stiffness", "overlap"),
    "force": ("displacement",),
}
"""What each law takes, in this order, under whatever names; um, uN, us: docs/own-physics.md."""
LAWS = 100_000, "write the laws alone"
"""Bytes that a file of laws may have, and what to do about more."""
Law = Annotated[Callable, Argument("a function of numbers", callable)]
REACH, POINTS = 10.0, 4001
"""Over the rise, how far a beam's second shape is looked for along its force, and at how many."""


@dataclass(frozen=True)
class Laws:
    """Compiled functions, as `reference` takes them; None where the device's own force acts."""

    damping: Callable | None = None
    contact: Callable | None = None
    force: Callable | None = None

    def __str__(self):
        """Name the functions, as attributes of products have them."""
        return ", ".join(f"{key}: {law.__name__}" for key, law in vars(self).items() if law)


def reference(
    damping: Law | None = None,
    contact: Law | None = None,
    force: Law | None = None,
) -> dict[str, object]:
    """Give the `reference` model your own laws, for sweep, threshold and simulate.

    damping: drag on the mass (uN) of (C, velocity, place), in place of C velocity
    contact: push between mass and midpoint (uN, positive apart) of (stiffness, overlap)
    force: push that holds the midpoint (uN) of (displacement,), in place of the beam's
    Laws are functions of floats (um, us) that numba compiles; docs/own-physics.md describes them.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cubic = snapmap.reference(damping=lambda C, velocity, place: C * velocity**3)
    >>> snapmap.simulate(device, 1000, 1500, 25, model=cubic, horizon=0).outcome
    'snapped'
    """
    functions = {"damping": damping, "contact": contact, "force": force}
    return {"name": "reference", "laws": made(functions)}


def made(functions: Mapping[str, object]) -> Laws:
    """Compile functions by the names of their laws; raises ValueError, one line, for no law."""
    laws = {key: _compiled(key, functions[key]) for key in PARAMETERS if functions.get(key)}
    if not laws:
        raise ValueError(f"model.laws: no law; write a function named {' or '.join(PARAMETERS)}")
    return Laws(**laws)


@cache
def load_laws(path: str, sha256: str = "") -> Laws:
    """Read the laws of a Python file, which is run; raises ValueError, one line, as `made`.

    sha256: expected hash of the file, hex digits; empty for any
    """
    with naming(f"model.laws: {path}"):
        content, names = read_named(path, *LAWS, sha256), {"__name__": Path(path).stem}
        try:
            exec(compile(content, path, "exec"), names)
        except Exception as error:  # a user's code may raise any
            raise ValueError(f"{type(error).__name__}: {error}") from None
    return made(names)


def laws_of(options: Mapping) -> Laws | None:
    """Give the laws of a model's options, if it has any: as they are, or by their file."""
    laws = options.get("laws")
    return load_laws(laws, options.get("sha256", "")) if isinstance(laws, str) else laws


def _compiled(key, law):
    """Compile a law, and hold it against what it takes and gives."""
    from numba import njit
    from numba.core.errors import NumbaError

    name, needs = f"model.laws: {key}", PARAMETERS[key]
    function = getattr(law, "py_func", law)
    if not inspect.isfunction(function):
        raise ValueError(f"{name}: is not a function")
    taken = inspect.signature(function).parameters
    if len(taken) != len(needs):
        raise ValueError(f"{name}: takes ({', '.join(taken)}); write ({', '.join(needs)})")
    law = law if law is not function else njit(error_model="numpy")(function)
    try:
        value = law(*np.full(len(needs), 0.25))
    except NumbaError as error:
        raise ValueError(
            f"{name}: numba cannot compile it; {' '.join(str(error).split())}"
        ) from None
    if not isinstance(value, float):
        raise ValueError(f"{name}: returns a {type(value).__name__}; return a float")
    return law


def well_of(force: Callable, rise: Value) -> tuple[float, float, float]:
    """Find saddle and second shape, um, and the energy of the saddle, pJ, of a double well.

    Displacements within REACH times the rise; raises ValueError for a force that is none.
    """
    reach = REACH * float(np.max(rise))
    x, F = _curve(force, 0.0, reach)
    falls = np.flatnonzero((F[1:-1] > 0) & (F[2:] <= 0)) + 1
    rises = np.flatnonzero((F[1:-1] < 0) & (F[2:] >= 0)) + 1
    rises = rises[rises > falls[0]] if falls.size else falls
    if abs(F[0]) > 1e-9 * abs(F).max() or not rises.size:
        needs = "0 at 0, then positive, negative from a saddle on, and positive again"
        raise ValueError(f"model.laws: force: no double well; make it {needs} below {reach:g} um")
    around = (_curve(force, *x[i : i + 2]) for i in (falls[0], rises[0]))
    saddle, second = (float(x[np.argmax(F[1:] * F[0] <= 0) + 1]) for x, F in around)
    x, F = _curve(force, 0.0, saddle)
    return saddle, second, float(np.sum((F[1:] + F[:-1]) * np.diff(x)) / 2)


def _curve(force, low, high):
    """Displacements in an interval, and the forces there."""
    x = np.linspace(low, high, POINTS)
    return x, np.array([force(place) for place in x.tolist()])
