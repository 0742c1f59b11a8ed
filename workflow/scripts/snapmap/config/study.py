"""The door: a config document to a `Config` in internal units, or one line for every fault."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydantic import ValidationError

from ..applications import attached, key_of, merge
from ..beam.equilibria import require_rest, second_shape, shapes_of
from ..device.device import VALUES, Device
from ..device.quantities import QUANTITIES
from ..files.named import hold_to_plan, sha256_of
from ..pulse.shocks import HANDOUT_SHOCK
from ..solver.settings import SECOND, THRESHOLD_TOLERANCE
from ..study.axes import SHOCK_AXES, TEMPERATURE, Grid, Units, make_grid
from ..study.study import Study
from .devices import nominal
from .keys import line_at, lines_of
from .measured_shape import PROFILE
from .models import Document
from .units import unit_of
from .views import View, choose_curves, choose_maps, frequency_of, read_places
from .yaml_file import ConfigError

AXES = *VALUES, *SHOCK_AXES
"""Keys of the section sweep that are axes, but for the duration, which is f0 by another name."""
OF_LAWS = ("histories",)
"""Applications that follow a model with a user's own laws, by their requests."""
DESIGN = *(key for key in VALUES if key != TEMPERATURE), "C"
"""Those that a design chooses."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Config(Study):
    """A study with the cells of its sweep, and what else is made of it.

    grid: all axes, each ascending
    pulse: its section, in internal units, with the SHA-256 of a record
    requests: what is asked of each application, by its folder; false for nothing
    threshold_tolerance: of the thresholds in N, relative
    maps, curves: what is drawn of cells and thresholds
    own_points: path and SHA-256 of a user's own points on the maps, or nothing
    left_out: one line on what is not drawn, or nothing
    measured: lines on shapes of beams that were read from files, by device and path
    title: of the data sheet
    written: the sections of the devices by their names, as they are written
    units: in which the axes of device and C are written
    """

    grid: Grid
    pulse: dict
    requests: dict[str, object]
    threshold_tolerance: float
    maps: tuple[View, ...]
    curves: tuple[View, ...]
    own_points: tuple[str, str] | tuple[()]
    left_out: str
    measured: dict[tuple[str, str], str]
    title: str
    written: dict[str, Mapping]
    units: Units

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values by name, in the order of all products."""
        return self.grid.axes

    @property
    def temperatures(self) -> list[float]:
        """Those at which requirements must be met, degC; none if that is each device's own."""
        return self.axes["temperature"].tolist() if "temperature" in self.axes else []

    def inputs(self, *keys: str) -> dict:
        """What its products depend on beside axes, in plain values: Snakemake compares them.

        keys: of the settings on which they depend; all of them by default
        """
        return self.document(keys) | {"pulse": self.pulse}

    def of_thresholds(self) -> "Config":
        """The same, each cell followed as all functions but `sweep` follow it."""
        return replace(self, settings=self.settings._replace(until="settled", repeat=True))

    @property
    def has_strength(self) -> bool:
        """Whether a beam may break."""
        return any(device.strength < np.inf for device in self.devices().values())

    def files(self) -> dict[str, str]:
        """SHA-256 of each file that the config names, as it was read, by path."""
        recorded = {self.pulse["file"]: self.pulse["sha256"]} if "file" in self.pulse else {}
        shapes = {path: sha256_of(path, *PROFILE) for _, path in self.measured}
        points = dict([self.own_points] if self.own_points else [])
        laws = {self.model["laws"]: self.model["sha256"]} if "laws" in self.model else {}
        return recorded | shapes | points | laws | merge("files", self)


def planned_study(document: Mapping, threads: int) -> Config:
    """The study of a job, of its run's config; ValueError, one line, for a file edited since."""
    study = load_config(document)
    hold_to_plan(study.files(), plans=False)
    return replace(study, settings=study.settings._replace(threads=threads))


def load_config(document: Mapping) -> Config:
    """Check a whole config document and convert it; raises ConfigError naming every fault."""
    try:
        parts = Document.model_validate(document)
    except ValidationError as error:
        raise ConfigError(*lines_of(error)) from None
    faults = []

    def part(path, make, *arguments):
        try:
            return make(*arguments)
        except ValueError as error:
            line = str(error)
            return faults.append(line if line.startswith("device") else line_at(path, line))

    device, sweep = parts.made, parts.sweep
    shocks = parts.pulse.made if parts.pulse else HANDOUT_SHOCK
    C = part(("devices",), _damper, parts)
    grid = None if faults else part(("sweep",), _grid, parts, shocks, C)

    def views(name, make):
        sections = getattr(parts, name)
        return sections and [part((name, i), make, view) for i, view in enumerate(sections)]

    maps, curves = None, None
    if grid:
        maps = views("maps", lambda v: (v.x, v.y, read_places(v.given, grid.axes)))
        curves = views("thresholds", lambda v: (v.x, v.lines, read_places(v.given, grid.axes)))
        part(("sweep",), require_start, sweep.made.start, grid.device)
    part(("device",), lambda: Study(device=device, shocks=shocks))  # forces shake no frame
    if faults:
        raise ConfigError(*dict.fromkeys(faults))
    chosen, left_out = choose_maps(grid, nominal(device), maps)
    study = Config(
        device=device,
        model=parts.model.made,
        grid=grid,
        skip=sweep.not_bistable == "skip",
        settings=sweep.made,
        shocks=shocks,
        pulse=parts.pulse.values() if parts.pulse else {},
        requests={},
        threshold_tolerance=sweep.threshold_tolerance or THRESHOLD_TOLERANCE,
        maps=chosen,
        curves=choose_curves(grid, nominal(device), curves),
        own_points=parts.marks or (),
        left_out=left_out,
        measured={
            (name, section.beam.shape.file): f"{name}, {section.beam.measured}"
            for name, section in parts.devices_by_name().items()
            if section.beam.measured
        },
        title=parts.title or "",
        written=document.get("devices") or {"device": document["device"]},
        units={key: _unit(key, document["sweep"][key]) for key in DESIGN if sweep.has(key)},
    )
    for name, application in attached().items():
        if hasattr(application, "request"):
            key = key_of(name, application)
            section = getattr(parts, key, None)
            study.requests[name] = part((key,), application.request, section, study, parts)
            if "laws" in study.model and study.requests[name] and name not in OF_LAWS:
                faults.append(f"{key}: does not work with model.laws; leave one of them out")
    if faults:
        raise ConfigError(*dict.fromkeys(faults))
    return study


def _unit(key, written):
    """The unit of the first value of an axis."""
    first = written["from"] if isinstance(written, Mapping) else written[0]
    return unit_of(first, QUANTITIES[key].kind)


def require_start(start: str, *devices: Device) -> None:
    """Raise ValueError unless beams stay in the shape in which they rest at first."""
    for beam in (device.beam for device in devices if start == SECOND):
        if np.any(beam.free):
            try:
                require_rest(second_shape(beam, shapes_of(beam)))
            except ValueError as error:
                raise ValueError(f".{error}") from None


def _damper(parts):
    """C by the quality factors of the devices, if they have any."""
    dampers = {section.C for section in parts.devices_by_name().values()}
    if parts.sweep.C is None and (len(dampers) > 1 or None in dampers):
        raise ValueError("quality factors give each device another C; write sweep.C")
    return dampers.pop()


def _grid(parts, shocks, C):
    """The points of the sweep, its axes in the order of the config."""
    sweep, axes = parts.sweep, {}
    for key, values in sweep.given.items():
        if key == "duration":
            axes["f0"] = np.array([frequency_of(value) for value in values[::-1].tolist()])
        elif key in AXES:
            axes[key] = values
    if "C" not in axes:
        axes["C"] = np.array([C])
    if "f0" not in axes:
        axes["f0"] = np.array([shocks.own_frequency()])
    skip = sweep.not_bistable == "skip"
    remedy = "write other values" if skip else "write other values, or not_bistable: skip"
    try:
        grid = make_grid(parts.made, axes, skip, shocks)
    except ValueError as error:
        line = str(error) if str(error).startswith("device") else f"{error}; {remedy}"
        raise ValueError(line) from None
    if (grid.device_of < 0).all():
        raise ValueError(f"sweep: no device has a second stable shape; {remedy}")
    return grid
