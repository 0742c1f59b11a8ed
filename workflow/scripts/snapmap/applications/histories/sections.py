"""The section `histories`: cells whose motion is kept in full."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...config.devices import of_device
from ...config.keys import argument, in_list, quantity
from ...config.shocks import one_time
from ...config.units import show
from ...config.views import frequency_of
from ...device.argument import Argument
from ...device.device import VALUES, Device, batch
from ...files.text import exact, stem_of
from ...study.axes import DEVICE


def _changed(name, kind):
    return quantity(kind, "in place of the device's", out="the device's own")


class CellSection(of_device(_changed)):
    """A cell whose time history is drawn."""

    N: quantity("number", "peak of the shock over gravity")
    f0: quantity("frequency", "1/duration of the shock", out="required, or `duration`")
    duration: quantity("pulse", "duration of the shock; replaces f0", out="`f0`")
    C: quantity("damper", "damping of the mass")
    device: argument(
        Argument("the name of one of the devices", lambda name: isinstance(name, str)),
        out="the first",
    )

    @classmethod
    def beside(cls, written: Mapping) -> dict[tuple, str]:
        """One of f0 and duration is there."""
        return one_time(written)


class History(NamedTuple):
    """A cell whose time history is drawn.

    name: stem of its files
    device: the study's device with the changes of this cell; N: multiples of g; f0: Hz; C: uN us/um
    changes: values that differ from the nominal device, and the device's name if it has one
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


def read_cell(cell: Mapping, device: Device | Mapping[str, Device]) -> History:
    """Take one cell of a study; raises ValueError, one line, for an invalid cell.

    cell: N, f0 or duration, C, and optionally the device's name and other values of the device, in
        internal units
    """
    name, changes = cell.get(DEVICE), {key: cell[key] for key in cell if key in VALUES}
    if isinstance(device, Mapping):
        name = next(iter(device)) if name is None else name
        if name not in device:
            known = ", ".join(device)
            raise ValueError(f"no device is called {show(name)}; write one of {known}")
        device = device[name]
    elif name is not None:
        raise ValueError("device: the study has a single device; leave it out")
    if changes:
        device = batch([device]).vary({k: np.array([v]) for k, v in changes.items()}).pick(0)
    if name is not None:
        changes = {DEVICE: name} | changes
    f0 = frequency_of(cell["duration"]) if "duration" in cell else cell["f0"]
    parts = {"N": cell["N"], "f": f0, "C": cell["C"], **changes}
    words = (v if k == DEVICE else f"{k}{exact(v)}" for k, v in parts.items())
    return History(stem_of(*words), device, cell["N"], f0, cell["C"], changes)


def read_cells(
    sections: Sequence[CellSection], device: Device | Mapping[str, Device]
) -> tuple[History, ...]:
    """Take the cells of a config; raises ValueError, one line, for an invalid cell."""
    cells = {}
    for place, section in enumerate(sections):
        try:
            cell = read_cell(section.given, device)
            if cell.name in cells:
                raise ValueError(f"{cell.name} is there already; leave it out")
        except ValueError as error:
            raise ValueError(in_list(place, str(error))) from None
        cells[cell.name] = cell
    return tuple(cells.values())
