"""The conversion of a config document to a `Config` in internal units."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..beam.equilibria import require_rest, second_shape, shapes_of
from ..device.device import VALUES, Device
from ..files.named import sha256_of
from ..pulse.pulse import N_of_g
from ..pulse.shocks import HANDOUT_SHOCK
from ..solver.options import Model
from ..solver.settings import SECOND
from ..study.axes import SHOCK_AXES, TEMPERATURE, Grid, Units, frequency_of, make_grid, unit_on
from ..study.study import Study
from ..values.faults import Faults, line_at
from ..values.kinds import kind_of
from ..values.units import OF_DAMPER, spelling_of
from .devices import PROFILE, nominal
from .document import Core
from .views import View, choose_curves, choose_maps, read_places

AXES = *VALUES, *SHOCK_AXES
"""Keys of the section sweep that are axes; `duration` is f0 by another name."""
DESIGN = *(key for key in VALUES if key != TEMPERATURE), "C"
"""Axes that a design chooses."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Config(Study):
    """A study with the cells of its sweep, and the requests for all its products.

    sections: the config as it was read, in records; source: as it was written
    grid: all points of the axes, each ascending
    maps, curves: figures of cells and of thresholds
    left_out: one line on maps that are not drawn, or an empty one
    requests: request to each application, by the name of its folder; false for no request
    """

    sections: Core
    source: Mapping
    grid: Grid
    maps: tuple[View, ...]
    curves: tuple[View, ...]
    left_out: str
    requests: Mapping[str, Any]

    @property
    def title(self) -> str:
        """Head of the data sheet."""
        return self.sections.title or ""

    @property
    def threshold_tolerance(self) -> float:
        """Relative refinement of the thresholds in N."""
        return self.sections.sweep.threshold_tolerance

    @property
    def own_points(self) -> tuple:
        """Path and SHA-256 of a user's own points on the maps, and N of 1 g; or ()."""
        marks = self.sections.marks
        return (*marks, N_of_g(nominal(self.device).gravity)) if marks else ()

    @property
    def measured(self) -> dict[tuple[str, str], str]:
        """Lines on shapes of beams that were read from files, by device and path."""
        beams = {name: section.beam for name, section in self.sections.by_name.items()}
        files = {name: beam for name, beam in beams.items() if beam.measured}
        return {(name, b.shape.file): f"{name}, {b.measured}" for name, b in files.items()}

    @property
    def written(self) -> dict[str, Mapping]:
        """Sections of the devices by name, as the config has them."""
        return self.source.get("devices") or {"device": self.source["device"]}

    @property
    def units(self) -> Units:
        """Units in which the config has the axes of device and C."""
        sweep = self.source["sweep"]
        keys = [key for key in DESIGN if key in sweep]
        return {key: _unit(sweep[key], unit_on(key, self.unit_of_C)) for key in keys}

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values of all axes by name, in the order that all products have."""
        return self.grid.axes

    @property
    def temperatures(self) -> list[float]:
        """Temperatures at which requirements must be met, degC; [] for each device's own."""
        return self.axes["temperature"].tolist() if "temperature" in self.axes else []

    def inputs(self, *keys: str) -> dict:
        """Give all but the axes that products depend on, in plain values that Snakemake compares.

        keys: names of the settings to include; all by default
        """
        return self.document(keys) | {"pulse": self.shocks.values()}

    def of_thresholds(self) -> "Config":
        """Give the study with the settings by which all functions but `sweep` follow cells."""
        return self.but(until="settled", repeat=True)

    def files(self) -> dict[str, str]:
        """Give the SHA-256 of each file that sections of the core name, as it was read, by path."""
        shapes = {path: sha256_of(path, *PROFILE) for _, path in self.measured}
        points = dict([self.own_points[:2]] if self.own_points else [])
        laws = self.model.laws
        of_laws = {laws.file: laws.sha256} if laws and laws.file else {}
        return self.shocks.files | shapes | points | of_laws


def unit_of_C(source: Mapping) -> str:
    """Give the unit of C of a config, which the laws of its model may state."""
    try:
        laws = kind_of(Model).read(source["model"]).laws
    except (KeyError, TypeError, ValueError):  # told beside all other faults
        laws = None
    return laws.unit_of_C if laws else OF_DAMPER


def convert(parts: Core, source: Mapping) -> Config:
    """Convert the sections of the core, without requests; Faults have a line for each fault."""
    faults, unit = Caught(), parts.model.laws.unit_of_C if parts.model.laws else OF_DAMPER
    named = {name: section.made for name, section in parts.by_name.items()}
    device = named if parts.devices else named["device"]
    shocks = parts.pulse.make_shocks() if parts.pulse else HANDOUT_SHOCK
    C = faults.catch(("devices",), _damper, parts, unit)
    grid = None if faults else faults.catch(("sweep",), _grid, parts, source, device, shocks, C)

    def views(name, y):
        def read(view):
            axes = view.x, getattr(view, y)
            return *axes, read_places(*axes, view.at, grid.axes, unit)

        sections = getattr(parts, name)
        return sections and [faults.catch((name, i), read, v) for i, v in enumerate(sections)]

    if grid:
        maps, curves = views("maps", "y"), views("thresholds", "lines")
        faults.catch(("run",), require_start, parts.run.start, grid.device)
    how = {"model": parts.model, "skip": parts.skip, **vars(parts.run)}
    how |= {"pulse": shocks.pulse, "direction": shocks.direction}
    faults.catch(("device",), lambda: Study(device, **how))  # refuses some forces
    faults.refuse()
    chosen, left_out = choose_maps(grid, nominal(device), maps)
    return Config(
        device=device,
        **how,
        sections=parts,
        source=source,
        grid=grid,
        maps=chosen,
        curves=choose_curves(grid, nominal(device), curves),
        left_out=left_out,
        requests={},
    )


class Caught(list):
    """Lines on the faults of a config."""

    def catch(self, path: tuple, function: Callable, *arguments: Any) -> Any:
        """Call a function, and take its ValueError as the fault of the key at a path."""
        try:
            return function(*arguments)
        except ValueError as error:
            line = str(error)
            self.append(line if line.startswith("device") else line_at(path, line))

    def refuse(self) -> None:
        """Raise Faults if there are some."""
        if self:
            raise Faults(*dict.fromkeys(self))


def _unit(written, unit):
    """Give the unit of the first value of an axis, as `spelling_of` does."""
    return spelling_of(written["from"] if isinstance(written, Mapping) else written[0], unit)


def require_start(start: str, *devices: Device) -> None:
    """Raise ValueError, one line, unless beams are stable in the shape in which they start."""
    for beam in (device.beam for device in devices if start == SECOND):
        if np.any(beam.free):
            try:
                require_rest(second_shape(beam, shapes_of(beam)))
            except ValueError as error:
                raise ValueError(f".{error}") from None


def _damper(parts, unit):
    """Give C by the quality factors of the devices, uN us/um; it does not count beside sweep.C."""
    dampers = {section.C for section in parts.by_name.values()}
    if dampers - {None, 0.0} and unit != OF_DAMPER:
        words = f"device.quality_factor: gives C in {OF_DAMPER}, but model.laws states {unit or 1}"
        raise ValueError(f"{words}; write sweep.C")
    if parts.sweep.C is None and (len(dampers) > 1 or None in dampers):
        raise ValueError("quality factors give each device another C; write sweep.C")
    return dampers.pop()


def _grid(parts, source, device, shocks, C):
    """Make the grid of the sweep, with axes in the order of the config; C: by `_damper`."""
    axes = {}
    for key in source["sweep"]:
        values = getattr(parts.sweep, key)
        if key == "duration":
            axes["f0"] = np.array([frequency_of(value) for value in values[::-1].tolist()])
        elif key in AXES:
            axes[key] = values
    if "C" not in axes:
        axes["C"] = np.array([C])
    if "f0" not in axes:
        axes["f0"] = np.array([shocks.own_frequency()])
    remedy = "write other values" if parts.skip else "write other values, or skip: true"
    try:
        grid = make_grid(device, axes, parts.skip, shocks)
    except ValueError as error:
        line = str(error) if str(error).startswith("device") else f"{error}; {remedy}"
        raise ValueError(line) from None
    if (grid.device_of < 0).all():
        raise ValueError(f"sweep: no device has a second stable shape; {remedy}")
    return grid
