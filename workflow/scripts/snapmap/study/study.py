"""A study: devices under shocks, a model, and how each cell is followed."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Annotated

import numpy as np

from ..device.device import Device
from ..pulse.shocks import HANDOUT_SHOCK, Directions, Pulses, Shocks
from ..solver.options import Auto, Model, section_of
from ..solver.settings import Run
from ..values.kinds import Fitting
from ..values.quantities import Truth
from ..values.records import record
from ..values.units import OF_DAMPER
from .axes import DEVICE, Grid, make_grid
from .provenance import device_sections

ANY, ARRIVES = "any", "arrives"
"""Values of `snaps` of a required shock that may or may not snap the device, and of one under which
the beam must arrive at its other shape, but need not stay there."""
SNAPS = {False: 0, True: 1, ANY: 2, ARRIVES: 3}
"""Codes of `snaps` in datasets."""
OF_THRESHOLDS = ("horizon", "energy_tolerance", "start")
"""Values of a run on which a threshold depends."""


def _is_single(device):
    """Tell whether a value is a device, and no batch of them."""
    if not isinstance(device, Device):
        return False
    parts = (device, device.beam)
    return not any(np.ndim(getattr(part, field.name)) for part in parts for field in fields(part))


def _are_single(value):
    named = value.values() if isinstance(value, Mapping) and value else [value]
    return all(map(_is_single, named))


DEVICES = Fitting(
    "a Device of single values, or several by name; load_device reads one", _are_single
)
Devices = Annotated[Device | Mapping[str, Device], DEVICES]


@record
class Study(Run):
    """A device, or several, under a shock; what every function works on.

    A Device alone is taken as a study of it.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, "3 cosines", until="snap", horizon="0.5 ms")
    >>> study.model, study.horizon
    (Cosines(modes=3), 500.0)
    """

    device: Devices
    """one device, or several by name, which are an axis"""
    model: Model = Auto()
    """how a cell is simulated: a model, its name, or with a number, as "3 cosines\""""
    pulse: Pulses = HANDOUT_SHOCK.pulse
    """the shock: a shape, a Pulse, or a train or drop as in a config; several are an axis"""
    direction: Directions = "+z"
    """+z presses the mass on the beam; several, or both, are an axis"""
    skip: Truth = False
    """whether devices without a second stable shape are left out, not refused"""

    def __post_init__(self):
        """Raise ValueError if a shock shakes the frame where the device is pushed by a force."""
        for pulse in self.shocks.shapes.values():
            if pulse.is_of_frame:
                self.require_frame(f"the shock {pulse.name!r}")

    @cached_property
    def shocks(self) -> Shocks:
        """Pulse and direction."""
        return Shocks(self.pulse, self.direction)

    def under(self, shocks: Shocks) -> "Study":
        """Give the study with other shocks."""
        return replace(self, pulse=shocks.pulse, direction=shocks.direction)

    @property
    def unit_of_C(self) -> str:
        """Unit of C, as a config spells it: a user's own law may state one."""
        return self.model.laws.unit_of_C if self.model.laws else OF_DAMPER

    def devices(self) -> dict[str, Device]:
        """Give the devices by name; a single one is called `device`."""
        return self.device if isinstance(self.device, Mapping) else {"device": self.device}

    def require_frame(self, what: str) -> None:
        """Raise ValueError if pulses are forces on the midpoint, but `what` shakes the frame."""
        if any(device.force for device in self.devices().values()):
            raise ValueError(f"device.force: {what} shakes the frame; write gravity instead")

    def set_out(self, axes: Mapping[str, Sequence]) -> Grid:
        """Make the grid of axes; ValueError, one line, for a point that cannot exist.

        axes: values by name, those of the device first; those that are None are left out, but f0
            is then that of a shock with a duration of its own
        """
        if "f0" in axes and axes["f0"] is None:
            axes = {**axes, "f0": self.shocks.own_frequency()}
        points = {key: values for key, values in axes.items() if values is not None}
        return make_grid(self.device, points, self.skip, self.shocks)

    def part(self, names: Mapping[str, Sequence[str]]) -> "Study":
        """Keep some names on the axes of devices, shapes and directions."""
        device = self.device
        if DEVICE in names:
            device = {name: device[name] for name in names[DEVICE]}
        return replace(self, device=device).under(self.shocks.part(names))

    def document(self, keys: Sequence[str] = ()) -> dict:
        """Give the sections of a config, but for the axes, in a unique spelling.

        keys: names of the values of the run to include; all by default
        """
        run, sections = self.section(), device_sections(self.device) | self.shocks.section()
        run = {key: run[key] for key in keys or run if key in run}
        return sections | {"model": section_of(self.model), "run": run}
