"""The door: a config document to a `Config` in internal units, or one line for every fault."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydantic import ValidationError

from ..axes import SHOCK_AXES, Grid, make_grid
from ..described import describe, excited
from ..device import VALUES, values_of
from ..io.measured_shape import PROFILE
from ..io.named import sha256_of
from ..shocks import HANDOUT_SHOCK, make_shocks
from ..solver.settings import THRESHOLD_TOLERANCE
from ..study import Study
from ..tolerances.samples import Plan, Tolerances
from .asked_views import read_view
from .calibration import Calibration, read_calibration
from .devices import nominal, pushed, stopped, tilting, unwarmed
from .histories import History, history, nearest_history
from .keys import line_at, lines_of
from .models import Document, frequency_of
from .plausible import implausible, proportions, wide
from .shocks import Requirement, SpectrumTest, Vibration, own_points_outside
from .views import View, choose_boundary, choose_curves, choose_maps
from .yaml_file import ConfigError

AXES = *VALUES, *SHOCK_AXES
"""Keys of the section sweep that are axes, but for the duration, which is f0 by another name."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Config(Study):
    """A study with the cells of its sweep, and what else is made of it.

    grid: all axes, each ascending
    pulse: values for `make_shocks`
    requirements: shocks that must or must not trip the device; vibrations, spectra: likewise
    tolerances: what scatters from device to device, or nothing
    calibration: measured shots, and what is read off them, or nothing
    threshold_tolerance: of the thresholds in N, relative
    maps, curves, boundary: what is drawn of cells, thresholds, and the damage boundary
    own_points: path and SHA-256 of a user's own points on the maps, or nothing
    left_out: one line on what is not drawn, or nothing
    measured: lines on shapes of beams that were read from files, by device and path
    """

    grid: Grid
    pulse: dict
    requirements: tuple[Requirement, ...]
    vibrations: tuple[Vibration, ...]
    spectra: tuple[SpectrumTest, ...]
    tolerances: Tolerances | None
    calibration: Calibration | None
    threshold_tolerance: float
    histories: tuple[History, ...]
    maps: tuple[View, ...]
    curves: tuple[View, ...]
    boundary: View
    own_points: tuple[str, str] | tuple[()]
    left_out: str
    measured: dict[tuple[str, str], str]

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values by name, in the order of all products."""
        return self.grid.axes

    @property
    def all_required(self) -> tuple[Requirement | Vibration | SpectrumTest, ...]:
        """What must or must not trip the device, of all kinds."""
        return *self.requirements, *self.vibrations, *self.spectra

    def values(self, *keys: str) -> dict:
        """Plain values of the study for `study_from`, with some of its settings; all by default."""
        settings = self.settings.without_threads()
        return {
            "device": values_of(self.device),
            "pulse": self.pulse,
            "model": self.model,
            "settings": {key: settings[key] for key in keys or settings},
            "skip": self.skip,
        }

    @property
    def has_strength(self) -> bool:
        """Whether a beam may break."""
        return any(one.strength < np.inf for one in self.devices().values())

    def descriptions(self) -> list[str]:
        """Lines on each device, whatever the axes change, and on how a record excites it."""
        C, lines = self.axes["C"], list(self.measured.values())
        records = [
            one for one in self.shocks.shapes.values() if one.duration and not one.blows.size
        ]
        for name, one in self.devices().items():
            lines.append(f"{name}: {proportions(one.beam)}; {describe(one, C)}")
            lines += [f"{name}, {pulse.name}: {excited(one, pulse)}" for pulse in records]
        return lines

    def files(self) -> dict[str, str]:
        """SHA-256 of each file that the config names, as it was read, by path."""
        pulses = [self.pulse, *(asked.pulse for asked in self.requirements)]
        own = dict([self.own_points] if self.own_points else [])
        shots = self.calibration.files if self.calibration else {}
        recorded = {one["file"]: one["sha256"] for one in pulses if "file" in one}
        shapes = {path: sha256_of(path, *PROFILE) for _, path in self.measured}
        return recorded | shapes | own | shots

    def doubts(self) -> list[str]:
        """Lines on what is hardly meant, and on what devices and recorded shocks may leave out."""
        shortest, device = 1e6 / self.axes["f0"][-1], nominal(self.device)
        each = self.devices().items()
        lines = [
            (name, line)
            for name, one in each
            for line in (tilting(one.beam), stopped(one), pushed(one))
        ]
        if "temperature" in self.axes:
            lines += [(name, unwarmed(one)) for name, one in each]
        pulses = [
            line
            for pulse in self.shocks.shapes.values()
            for line in pulse.doubts(float(device.own_frequency), float(shortest))
        ]
        unlikely = implausible(self.grid.device, self.axes["C"], self.axes["f0"])
        outside = own_points_outside(self.own_points[0], self.axes) if self.own_points else []
        named = [f"{name}: {line}" for name, line in lines if line]
        scatters = [
            line
            for one in (self.devices().values() if self.tolerances else ())
            for line in wide(Plan(one, self.tolerances.scatters, self.tolerances.together))
        ]
        return unlikely + named + pulses + outside + scatters


def load_config(document: Mapping) -> Config:
    """Check a whole config document and convert it; raises ConfigError naming every fault."""
    try:
        parts = Document.model_validate(document)
    except ValidationError as error:
        raise ConfigError(*lines_of(error)) from None
    faults = []

    def part(path, make, *given):
        try:
            return make(*given)
        except ValueError as error:
            line = str(error)
            of_device = path == ("sweep",) and line.startswith("device")
            return faults.append(line if of_device else line_at(path, line))

    device, sweep = parts.made, parts.sweep
    shocks = parts.pulse.made if parts.pulse else HANDOUT_SHOCK
    C = part(("devices",), _damper, parts)
    grid = None if faults else part(("sweep",), _grid, parts, shocks, C)
    tolerances = parts.tolerances.made if parts.tolerances else None
    for one in parts.devices_by_name().values() if tolerances else ():
        part(("tolerances",), Plan, one.made, tolerances.scatters, tolerances.together)
    cells = [
        part(("histories", place), history, cell.given, device)
        for place, cell in enumerate(parts.histories or ())
    ]
    calibration, maps, curves = None, None, None
    if grid and parts.calibration:
        given = parts.calibration, device, shocks, grid.axes["C"]
        calibration = part(("calibration",), read_calibration, *given)
    if grid:
        maps, curves = (
            sections
            and [
                part((name, place), read_view, view.given, grid.axes)
                for place, view in enumerate(sections)
            ]
            for name, sections in (("maps", parts.maps), ("thresholds", parts.thresholds))
        )
    required = [one.made for one in parts.requirements or ()]
    requirements, vibrations, spectra = (
        tuple(one for one in required if isinstance(one, kind))
        for kind in (Requirement, Vibration, SpectrumTest)
    )
    part(("device",), _require_study, device, shocks, required, tolerances)
    if faults:
        raise ConfigError(*dict.fromkeys(faults))
    chosen, left_out = choose_maps(grid, nominal(device), maps)
    if parts.histories is None:
        cells = [nearest_history(device, grid)]
    return Config(
        device=device,
        model=parts.model.given,
        grid=grid,
        skip=sweep.not_bistable == "skip",
        settings=sweep.made,
        shocks=shocks,
        pulse=parts.pulse.values() if parts.pulse else {},
        requirements=requirements,
        vibrations=vibrations,
        spectra=spectra,
        tolerances=tolerances,
        calibration=calibration,
        threshold_tolerance=sweep.threshold_tolerance or THRESHOLD_TOLERANCE,
        histories=tuple(cells),
        maps=chosen,
        curves=choose_curves(grid, nominal(device), curves),
        boundary=choose_boundary(grid, nominal(device)),
        own_points=parts.marks or (),
        left_out=left_out,
        measured={
            (name, one.beam.shape.file): f"{name}, {one.beam.measured}"
            for name, one in parts.devices_by_name().items()
            if one.beam.measured
        },
    )


def _require_study(device, shocks, required, tolerances):
    """What is found of the device itself, whatever the axes make of it; forces shake no frame."""
    own = Study(device=device, shocks=shocks)
    if required or tolerances:
        own.set_out({})
    for asked in required:
        if isinstance(asked, Requirement):
            replace(own, shocks=make_shocks(asked.pulse))
        else:
            own.require_frame("a spectrum among the requirements")


def _damper(parts):
    """C by the quality factors of the devices, if they have any."""
    dampers = {section.C for section in parts.devices_by_name().values()}
    if parts.sweep.C is None and (len(dampers) > 1 or None in dampers):
        raise ValueError("quality factors give no C that all devices share; write sweep.C")
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
        raise ValueError(f"no device has a second stable shape; {remedy}")
    return grid
