"""A study: devices under shocks, a model, and how each cell is followed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ..device.device import VALUES, Device
from ..pulse.shocks import HANDOUT_SHOCK, Shocks, make_shocks
from ..solver.settings import Run, settings_of
from .axes import DEVICE, Grid, make_grid
from .provenance import device_sections

ANY, ARRIVES = "any", "arrives"
"""Values of `snaps` of a required shock that may or may not snap the device, and of one under which
the beam must arrive at its other shape, but need not stay there."""
SNAPS = {False: 0, True: 1, ANY: 2, ARRIVES: 3}
"""Codes of `snaps` in datasets."""
OF_THRESHOLDS = ("horizon", "energy_tolerance", "start")
"""Run on which a threshold depends."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Study:
    """What every public function works on; a config makes it, or `study_of` from arguments.

    device: nominal device, or several by name, which are an axis
    shocks: shapes and directions of the pulse; several are axes
    model: name and options, as in the config
    settings: how each cell is followed
    skip: whether devices without a second stable shape are left out, and not refused
    """

    device: Device | Mapping[str, Device]
    shocks: Shocks = HANDOUT_SHOCK
    model: Mapping = field(default_factory=lambda: {"name": "auto"})
    settings: Run = field(default_factory=Run)
    skip: bool = False

    def __post_init__(self):
        """Raise ValueError if a shock shakes the frame where the device is pushed by a force."""
        for pulse in self.shocks.shapes.values():
            if pulse.is_of_frame:
                self.require_frame(f"the shock {pulse.name!r}")

    def devices(self) -> dict[str, Device]:
        """Give the devices by name; a single one is called `device`."""
        return self.device if isinstance(self.device, Mapping) else {"device": self.device}

    def require_frame(self, what: str) -> None:
        """Raise ValueError if pulses are forces on the midpoint, but `what` shakes the frame."""
        if any(device.force for device in self.devices().values()):
            raise ValueError(f"device.force: {what} shakes the frame; write gravity instead")

    def set_out(self, axes: Mapping[str, Sequence]) -> Grid:
        """Make the grid of axes; ValueError, one line, for a point that cannot exist."""
        return make_grid(self.device, axes, self.skip, self.shocks)

    def part(self, names: Mapping[str, Sequence[str]]) -> "Study":
        """Keep some names on the axes of devices, shapes and directions."""
        device = self.device
        if DEVICE in names:
            device = {name: device[name] for name in names[DEVICE]}
        return replace(self, device=device, shocks=self.shocks.part(names))

    def document(self, keys: Sequence[str] = ()) -> dict:
        """Give the sections of a config, but for the axes, in a unique spelling.

        keys: names of the settings to include; all by default
        """
        settings = self.settings.without_threads()
        settings |= {"horizon": f"{settings['horizon']:.15g} us"}
        sections = device_sections(self.device) | self.shocks.section()
        sweep = {key: settings[key] for key in keys or settings if key in settings}
        return sections | {"model": dict(self.model), "sweep": sweep}


def study_of(
    device: Device | Mapping[str, Device], model: str | Mapping, options: Mapping, **shock
) -> tuple[Study, dict[str, Sequence]]:
    """Make a study, and its axes by name, of a function's arguments; raises ValueError, one line.

    model: name, or a mapping as in the config
    options: fields of `Run`; pulse and direction, as `make_shocks` takes them; skip; values of
        the device, which are axes; and options of the model
    shock: values of C, f0 and N; f0 = None means that of a recorded shock, others are left out
    """
    options = dict(options)

    def take(names):
        return {key: options.pop(key) for key in [*options] if key in names}

    shocks, settings = (
        make_shocks(**take(("pulse", "direction"))),
        settings_of(take(Run._fields)),
    )
    skip, axes = options.pop("skip", False), take(VALUES)
    if "f0" in shock and shock["f0"] is None:
        shock["f0"] = shocks.own_frequency()
    axes |= {key: values for key, values in shock.items() if values is not None}
    model = ({"name": model} if isinstance(model, str) else dict(model)) | options
    return Study(device=device, shocks=shocks, model=model, settings=settings, skip=skip), axes
