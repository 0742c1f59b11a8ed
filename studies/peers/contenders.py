"""The contenders: each a solver at a setting, and the package that it needs."""

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

from ..common import few
from .diffrax_cells import by_diffrax
from .heyoka_taylor import by_heyoka
from .kernel import by_kernel, by_plain_loop
from .numba_loop import by_numba
from .scene import COSINES, ELEMENTS
from .scipy_ivp import by_scipy

OURS, NO_PROOFS = "snapmap", "snapmap, to the end"
NUMBA, PLAIN = "numba loop", "plain loop"
PEERS = "heyoka", "diffrax"
"""Packages that follow cells; they are measured where they are installed."""
FACTORS = 2.0, 1.0, 0.5, 0.25, 0.125
STEPS = 0.2, 0.1, 0.05, 0.025
"""Steps of snapmap, over the default ones, and of the numba loop, us."""
LANES, SIDE_BY_SIDE = 16, 16
"""Cells that the kernel follows at once, and those that diffrax is given to find one threshold."""
SLOW, FEWER = 67, 3
"""Strides through the map and through the rows for solvers that follow some ten cells a second."""


class Contender(NamedTuple):
    """A solver at a setting.

    make: function of a scene that returns the solver
    stride: through the cells of the map
    width: cells that it follows best at once
    """

    solver: str
    setting: str
    make: Callable
    equations: str = COSINES
    stride: int = 1
    width: int = 1

    @property
    def rows(self) -> slice:
        """Return the rows that it is asked for."""
        return slice(None, None, FEWER if self.stride > 1 else 1)


def contenders() -> Iterator[Contender]:
    """Yield the contenders whose packages are installed, snapmap first."""
    for solver, proofs in ((OURS, True), (NO_PROOFS, False)):
        for factor in few(FACTORS, 2):
            make = partial(by_kernel, factor=factor, proofs=proofs)
            yield Contender(solver, f"step x {factor:g}", make, width=LANES)
    for dt in few(STEPS):
        yield Contender(NUMBA, f"{dt:g} us", of_equations(by_numba, dt), width=LANES)
    if "heyoka" not in missing():
        for tolerance in few((1e-9, 1e-14)):
            yield Contender("heyoka", f"{tolerance:g}", of_equations(by_heyoka, tolerance), width=4)
    if "diffrax" not in missing():
        side_by_side = of_equations(by_diffrax, 1e-6)
        yield Contender("diffrax", "Tsit5, 1e-06", side_by_side, width=SIDE_BY_SIDE)
    for method in few(("DOP853", "RK45")):
        one_by_one = of_equations(by_scipy, method, 1e-6)
        yield Contender("SciPy", f"{method}, 1e-06", one_by_one, stride=SLOW)
    yield Contender(OURS, "step x 1", partial(by_kernel, factor=1.0), ELEMENTS, width=LANES)
    yield Contender(PLAIN, "0.8 of its limit", by_plain_loop, ELEMENTS, stride=SLOW)


def of_equations(make: Callable, *setting) -> Callable:
    """Make a function of a scene from one of its equations and a setting."""
    return lambda scene: make(scene.equations, *setting)


def missing() -> list[str]:
    """Return the packages of PEERS that are not installed."""
    return [name for name in PEERS if not find_spec(name)]
