"""A study: devices under shocks, a model of them, and how each cell is followed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .axes import DEVICE, Grid, make_grid, split_axes
from .device import Device
from .io.provenance import asked_for
from .pulse import HANDOUT_SHOCK, VERSED_SINE, Shocks, shocks_from
from .solver.settings import Settings
from .trains import pulses_of

FOLLOWED = ("horizon", "energy_tolerance", "threads")
"""Settings that every verb takes from Python."""
THRESHOLD_SETTINGS = ("horizon", "energy_tolerance")
"""Those on which a threshold depends."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Study:
    """What every verb takes: from a config or, by `study_of`, from Python.

    device: the nominal one, or several by name, which then are an axis
    shocks: shapes and directions of the pulse; several are axes
    model: name and options, as in the config
    settings: how each cell is followed
    skip: whether a device without a second stable shape is left out, not refused
    """

    device: Device | Mapping[str, Device]
    shocks: Shocks = HANDOUT_SHOCK
    model: Mapping = field(default_factory=lambda: {"name": "auto"})
    settings: Settings = field(default_factory=Settings)
    skip: bool = False

    def __post_init__(self):
        """Raise ValueError for shocks that are no force."""
        for pulse in self.shocks.shapes.values():
            if pulse.is_of_frame:
                self.require_frame(f"the shock {pulse.name!r}")

    def devices(self) -> dict[str, Device]:
        """Its devices by name; one alone is called `device`."""
        return self.device if isinstance(self.device, Mapping) else {"device": self.device}

    def require_frame(self, what: str) -> None:
        """Raise ValueError if pulses are forces on the midpoint, where `what` shakes the frame."""
        if any(one.force for one in self.devices().values()):
            raise ValueError(f"device.force: {what} shakes the frame; write gravity in its place")

    def set_out(self, axes: Mapping[str, Sequence]) -> Grid:
        """The points of axes; ValueError, one line, for one that cannot be."""
        return make_grid(self.device, axes, self.skip, self.shocks)

    def part(self, names: Mapping[str, Sequence[str]]) -> "Study":
        """The same with some of the names on its axes of devices, shapes and directions."""
        device = self.device
        if DEVICE in names:
            device = {name: device[name] for name in names[DEVICE]}
        return replace(self, device=device, shocks=self.shocks.some(names))

    def document(self, keys: Sequence[str] = ()) -> dict:
        """What its products say was asked for: the same however it was spelt.

        keys: of the settings on which they depend; all of them by default
        """
        settings = self.settings.asked()
        kept = {key: settings[key] for key in keys or settings}
        return asked_for(self.device, self.shocks, self.model, kept)


def study_of(
    device: Device | Mapping[str, Device],
    model: str | Mapping,
    options: Mapping,
    taken: Sequence[str] = FOLLOWED,
) -> tuple[Study, dict[str, Sequence]]:
    """Make a study of a verb's keywords; raises ValueError, one line.

    model: name, or as a mapping the whole of the config's model section
    options: some of `taken`, as in `Settings`; pulse (a shape by name, what `read_pulse` gives, or
        {"train": ...}, {"drop": ...}, {"sweep": ...} of `trains.MAKERS`; several are an axis) and
        direction ("+z", "-z", several, or "both"); skip; values of the device, which are axes; and
        options of the model
    Returns the study, and the device's axes by name.
    """
    options = dict(options)
    pulse = pulses_of(options.pop("pulse", VERSED_SINE))
    shocks = shocks_from(pulse, options.pop("direction", "+z"))
    settings = Settings(**{key: options.pop(key) for key in taken if key in options})
    skip = options.pop("skip", False)
    axes, options = split_axes(options)
    named = {"name": model} if isinstance(model, str) else dict(model)
    model = named | options
    return Study(device=device, shocks=shocks, model=model, settings=settings, skip=skip), axes


def frequencies(f0: Sequence[float] | None, shocks: Shocks) -> Sequence[float] | np.ndarray:
    """Frequencies as given, Hz; the own one of recorded shocks for None."""
    return [shocks.own_frequency()] if f0 is None else f0


def with_shocks(asked: Mapping) -> dict:
    """A requirement with `shocks`, by default of its `pulse` and `direction`, as in Python."""
    pulse, direction = asked.get("pulse", VERSED_SINE), asked.get("direction", "+z")
    return {"shocks": shocks_from(pulse, direction), **asked}
