"""The section `histories`: cells whose motion is kept in full."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from ...device.device import VALUES, Device, batch
from ...files.text import describe, exact, stem_of
from ...study.axes import DEVICE, KIND_OF, frequency_of
from ...values.arguments import one_time
from ...values.faults import at_key
from ...values.quantities import Amplitude, Damper, Frequency, PulseTime
from ...values.records import record, row_of_kinds, told

if TYPE_CHECKING:
    from ...config.study import Config


def _changed(key):
    return Annotated[float | str, KIND_OF[key]], "value in place of the device's own"


@record
class CellSection(row_of_kinds("Changes", {key: _changed(key) for key in VALUES})):
    """A cell whose time history is drawn."""

    N: Amplitude | None = None
    """peak of the shock over gravity"""
    f0: Frequency | None = None
    """1/duration of the shock; required, or `duration`, or a pulse that has its own"""
    duration: PulseTime | None = None
    """duration of the shock; replaces f0"""
    C: Damper | None = None
    """damping of the mass; required, unless the study has a single C"""
    device: str | None = None
    """name of one of the devices; the first if left out"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find keys that are missing, or that exclude each other."""
        needs = {} if "N" in written else {"N": f"missing; write {KIND_OF['N'].asks}"}
        return needs | one_time(written, lasts_itself=True)


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
            raise ValueError(f"no device is called {describe(name)}; write one of {known}")
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


def _owned(study, cell):
    """Add what the study alone says of a cell."""
    damping, last = study.axes["C"].tolist(), study.shocks.first().pulse.duration
    if "C" not in cell and len(damping) > 1:
        raise ValueError(f".C: missing; write {KIND_OF['C'].asks}")
    if faults := one_time(cell, lasts_itself=last is not None):
        raise ValueError(f".f0: {faults['f0']}")
    own = {} if "duration" in cell or last is None else {"f0": 1e6 / last}
    return {"C": damping[0]} | own | cell


def read_cells(sections: Sequence[CellSection], study: "Config") -> tuple[History, ...]:
    """Take the cells of a config; raises ValueError, one line, for an invalid cell.

    A cell without C, f0 and duration has those of the study, if it has a single C, and a shock with
    its own duration.
    """
    cells = {}
    for place, section in enumerate(sections):
        with at_key(place):
            cell = read_cell(_owned(study, told(section)), study.device)
            if cell.name in cells:
                raise ValueError(f"{cell.name} is there already; leave it out")
        cells[cell.name] = cell
    return tuple(cells.values())
