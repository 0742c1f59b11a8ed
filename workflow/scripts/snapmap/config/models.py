"""The sections of a config but device and shock, and the whole config: `Document`."""

import re
from collections.abc import Mapping
from typing import Annotated

from pydantic import create_model

from ..applications import gather
from ..device.argument import Argument
from ..device.device import Device
from ..device.quantities import QUANTITIES
from ..files.named import sha256_of
from ..files.tables import ROWS
from ..files.text import is_title
from ..solver.adaptive import TOLERANCE
from ..solver.laws import LAWS, load_laws
from ..solver.options import OF_MODEL, OPTIONS, take_model
from ..solver.settings import FIRST, STARTS, THRESHOLD_TOLERANCE, Settings, settings_of
from ..study import arguments
from ..study.axes import COORDINATES, axis_behind
from .devices import DeviceSection, of_device
from .keys import Section, argument, axis, flag, many, part, path, quantity, word, words
from .points import read_points
from .shocks import TIMED, PulseSection, one_time
from .units import show
from .views import MOST_MAPS


def _read_by(read, *limits):
    """Make a function that checks a file by reading it, and returns its path and SHA-256."""

    def convert(file):
        sha256 = sha256_of(file, *limits)
        read(file, sha256)
        return file, sha256

    return convert


class ModelSection(Section):
    """How a cell is simulated."""

    known_as = "model"

    name: word(*OPTIONS)
    elements: argument(OF_MODEL["elements"], "number of elements on the half beam", out="`5`")
    cosines: argument(OF_MODEL["cosines"], "number of symmetric cosines", out="as many as `modes`")
    modes: argument(
        OF_MODEL["modes"],
        "number of modes",
        out="`5` cosines; elements: all, with hard contact three quarters",
    )
    tolerance: quantity(
        "share", "largest relative error of thresholds", out=f"`{100 * TOLERANCE:g} %`"
    )
    laws: path(
        "a Python file in the study's folder with laws for `reference`",
        "mylaws.py",
        "the device's own",
        _read_by(load_laws, *LAWS),
    )

    def make(self) -> dict:
        """Make name and options of the model, with the SHA-256 of a file of laws."""
        files = dict(zip(("laws", "sha256"), self.laws or (), strict=False))
        return take_model(self.given | files) if files else self.given


_Axes = of_device(lambda _, kind: axis(kind, "in place of the device's", out="the device's own"))


class SweepSection(_Axes):
    """The axes, and how each cell is followed."""

    N: axis("number", "peak of the shock over gravity", "{from: 600, to: 2400, points: 91}")
    f0: axis(
        "frequency",
        "1/duration of the shock",
        "{from: 100 Hz, to: 30 kHz, points: 31, spacing: log}",
        "required, or `duration`, or a pulse that has its own",
    )
    duration: axis("pulse", "duration of the shock; replaces f0", "[0.3 ms, 0.5 ms]", "`f0`")
    C: axis(
        "damper",
        "damping of the mass",
        "[0.025 uN*us/um, 25 uN*us/um]",
        "required, or `device.quality_factor`, or no mass",
    )
    not_bistable: word(
        *("refuse", "skip"),
        what="points without a second stable shape",
        out="`refuse`",
    )
    horizon: quantity("duration", "time that each cell is followed after the pulse")
    start: word(*STARTS, what="shape in which the beam rests at first", out=f"`{FIRST}`")
    until: argument(
        arguments.Until,
        "a run ends when it has settled in a well; `snap`: or at its snap",
        out="`settled`",
    )
    repeat: flag(
        "whether each cell runs again with another step", out="`true` where `until` is `settled`"
    )
    energy_tolerance: argument(
        arguments.EnergyTolerance,
        "largest residual of the energy ledger over the pulse's work",
        out=f"`{Settings().energy_tolerance:g}`",
    )
    threshold_tolerance: argument(
        arguments.Refinement,
        "relative refinement of thresholds in N",
        out=f"`{THRESHOLD_TOLERANCE:g}`",
    )

    def make(self) -> Settings:
        """Make the settings by which cells are followed."""
        names = "horizon", "start", "until", "repeat", "energy_tolerance"
        return settings_of({name: self.given[name] for name in names if self.has(name)})


AXES = [name for name in QUANTITIES if axis_behind(name) in COORDINATES]


def _axis_name(what, *but):
    need = f"the name of an axis{' other than '.join(['', *but])}"
    return argument(Argument(need, lambda value: value in AXES and value not in but), what)


_PLACE = Annotated[
    dict[str, object],
    words(
        "a mapping of axes to values; the nearest is taken",
        out="the device's own values, else the middle; maps: no N",
    ),
]


class MapSection(Section):
    """A map over two axes."""

    x: _axis_name("horizontal axis")
    y: _axis_name("vertical axis; a map without N shows thresholds")
    at: _PLACE


class LinesSection(Section):
    """A figure of thresholds over two axes."""

    x: _axis_name("horizontal axis", "N")
    lines: _axis_name("each value is a line", "N")
    at: _PLACE


class _Core(Section):
    """Device (or devices), model and sweep; the others are optional."""

    title: argument(
        Argument("a line of letters, digits, spaces, .,:()/%+-_, at most 60", is_title),
        "head of the data sheet",
        "Crash sensor A, 2026-11-23",
        "none",
    )
    device: part(DeviceSection, out="required, or `devices`")
    devices: Annotated[
        dict[object, DeviceSection],
        words("a mapping of devices by name, which are an axis", out="`device`", min_length=1),
    ]
    model: part(ModelSection)
    pulse: part(PulseSection, out="a versed sine along +z")
    sweep: part(SweepSection)
    maps: many(
        MapSection,
        "a list of maps {x, y, at}",
        out=f"N over f0 at each point of the other axes, at most {MOST_MAPS}",
    )
    thresholds: many(
        LinesSection,
        "a list of figures {x, lines, at} of thresholds",
        out="over each axis, lines for `device` or C",
    )
    marks: path(
        "a CSV table in the study's folder of points on maps: N, f0 (Hz) or duration (ms), "
        "optionally name, snapped (yes, no)",
        "points.csv",
        "none",
        _read_by(read_points, *ROWS),
    )

    @classmethod
    def beside(cls, document: Mapping) -> dict[tuple, str]:
        """Find sections and keys that are missing, or that exclude others."""
        faults, sweep, several = {}, document.get("sweep"), document.get("devices")
        if "device" not in document and "devices" not in document:
            faults["device",] = f"missing; write {cls.needs()['device']}"
        elif "device" in document and "devices" in document:
            faults["devices",] = "excludes device; write one of them"
        several = several if isinstance(several, Mapping) else {}
        for name in several:
            if not (isinstance(name, str) and re.fullmatch("[A-Za-z][A-Za-z0-9_-]{0,30}", name)):
                need = "a name of letters, digits, - and _, at most 31 of them"
                faults["devices", name] = f"{show(name)} is not {need}"
        if isinstance(sweep, Mapping):
            pulse = document.get("pulse")
            itself = isinstance(pulse, Mapping) and any(name in pulse for name in TIMED)
            faults |= one_time(sweep, itself, ("sweep",))
            faults |= _dampers(document, sweep, several)
        return faults

    def make(self) -> Device | dict[str, Device]:
        """Make the device, or several by name."""
        if self.device:
            return self.device.made
        return {name: section.made for name, section in self.devices.items()}

    def devices_by_name(self) -> dict[str, DeviceSection]:
        """Give the sections of the devices; a single one is called `device`."""
        return self.devices or {"device": self.device}


_SECTIONS = gather(lambda part: part.section())
Document = create_model("Document", __base__=_Core, __doc__=_Core.__doc__, **_SECTIONS)
"""The whole config: sections of the core and of all applications."""


def _dampers(document, sweep, several):
    """Find what is wrong with C, which stands under sweep or follows from the quality factors."""
    at = {("devices", name): device for name, device in several.items()}
    at = at or {("device",): document.get("device")}
    at = {path: device for path, device in at.items() if isinstance(device, Mapping)}
    if at and all(device.get("mass") == "none" for device in at.values()):
        extra = {("sweep", "C"): "needs a mass; leave it out"}
        return extra if "C" in sweep else {}
    factors = [(*path, "quality_factor") for path in at if "quality_factor" in at[path]]
    if "C" in sweep:
        return dict.fromkeys(factors, "replaces sweep.C; write one of them")
    wanted = "dampers (force time per length) of the mass, or device.quality_factor"
    return {} if factors else {("sweep", "C"): f"missing; write {wanted}"}
