"""A user's laws as kernels take them: a damping compiled for lanes."""

from functools import cache

import numpy as np
from numba import carray, cfunc, types

from ..numerics.kernels import inlined, widen_vectors
from .kernel.laws import LaneLaws
from .kernel.rows import LANES
from .law_tables import Tables
from .laws import Laws, of_user


def lane_laws(laws: Laws | None, tables: Tables | None) -> LaneLaws | None:
    """Make a user's laws as a call of a kernel takes them; None without any."""
    if laws is None or tables is None:
        return None
    address = _of_lanes(laws.damping).address if laws.damping else 0
    asked, holds = np.zeros(5 * LANES), laws.force is not None
    return LaneLaws(address, asked, holds or laws.contact is not None, holds, tables.values)


def raise_error(laws: Laws | None, lanes: LaneLaws | None) -> None:
    """Raise the error of a damping, if it made one in a kernel, as a ValueError of one line."""
    if laws and laws.damping and lanes and lanes.asked[4 * LANES]:
        with of_user("damping"):
            for row in lanes.asked[: 3 * LANES].reshape(3, LANES).T.tolist():
                laws.damping(*row)


@cache
def _of_lanes(law):
    """Compile a law of damping for rows of LANES numbers, as `kernel.laws.LaneLaws` says."""
    with of_user("damping", law):
        drag = inlined(getattr(law, "py_func", law))

        @cfunc(types.void(types.CPointer(types.float64)), error_model="numpy")
        def follow(address):
            widen_vectors()
            asked = carray(address, 5 * LANES)
            if asked[4 * LANES] != 0.0:
                return
            try:
                for l in range(LANES):
                    C, velocity, place = asked[l], asked[LANES + l], asked[2 * LANES + l]
                    asked[3 * LANES + l] = drag(C, velocity, place)
            except Exception:
                asked[4 * LANES] = 1.0
                for l in range(LANES):
                    asked[3 * LANES + l] = np.nan

        return follow
