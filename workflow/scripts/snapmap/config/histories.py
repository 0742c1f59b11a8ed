"""The cells of a config that are followed in full."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..axes import DEVICE, PULSE_AXES, SHOCK_AXES, Grid
from ..device import VALUES, Device, batch
from .devices import nominal
from .models import frequency_of
from .units import show
from .views import HANDOUT_CASE, nearest_cell, value_name


class History(NamedTuple):
    """A cell whose time history is drawn.

    name: of its files
    device: the study's, with what the cell changes; N: multiples of g; f0: Hz; C: uN us/um
    changes: the values of the device that are not the nominal ones, and its name if it has one
    """

    name: str
    device: Device
    N: float
    f0: float
    C: float
    changes: dict[str, float | str]

    @property
    def shock(self) -> dict[str, float]:
        """N, f0 and C."""
        return {"N": self.N, "f0": self.f0, "C": self.C}


def nearest_history(device: Device | Mapping[str, Device], grid: Grid) -> History:
    """The grid's cell nearest the handout's case."""
    at = nearest_cell(grid, nominal(device), HANDOUT_CASE)
    values = {key: grid.axes[key][place].item() for key, place in at.items()}
    names = {"N": "N", "f": "f0", "C": "C"}
    names |= {key: key for key in at if key not in (*SHOCK_AXES, *PULSE_AXES)}
    named = (value_name(word, grid.axes[key], at[key]) for word, key in names.items())
    cell = {key: value for key, value in values.items() if key not in PULSE_AXES}
    return history(cell, device)._replace(name="_".join(named))


def history(cell: Mapping, device: Device | Mapping[str, Device]) -> History:
    """A cell of a study; ValueError, one line, for one that cannot be.

    cell: N, f0 or duration, C, its device's name and other values of it, in internal units
    """
    name = cell.get(DEVICE)
    if isinstance(device, Mapping):
        name = next(iter(device)) if name is None else name
        if name not in device:
            known = ", ".join(device)
            raise ValueError(f"no device is called {show(name)}; known are {known}")
        device = device[name]
    elif name is not None:
        raise ValueError("device is for studies of several devices; leave it out")
    values = {key: cell[key] for key in cell if key != DEVICE}
    if "duration" in values:
        values["f0"] = frequency_of(values.pop("duration"))
    changes = {key: values[key] for key in values if key in VALUES}
    if changes:
        device = batch([device]).vary({k: np.array([v]) for k, v in changes.items()}).pick(0)
    if name is not None:
        changes = {DEVICE: name} | changes
    N, f0, C = (values[key] for key in ("N", "f0", "C"))
    parts = {"N": N, "f": f0, "C": C, **changes}
    words = "_".join(v if k == DEVICE else f"{k}{v:.15g}" for k, v in parts.items())
    return History(words.replace("inf", "hard"), device, N, f0, C, changes)
