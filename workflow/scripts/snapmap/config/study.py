"""The door: a config document to a `Config` in internal units, or one line for every fault."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..axes import Grid, make_grid
from ..described import describe, excited
from ..device import VALUES, values_of
from ..io.measured_shape import PROFILE
from ..io.named import sha256_of
from ..io.recorded import shocks_of
from ..pulse import HANDOUT_SHOCK
from ..solver.settings import THRESHOLD_TOLERANCE, Settings
from ..study import Study
from ..tolerances.samples import Plan, Tolerances
from .asked_views import read_views
from .axes import read_axis
from .calibration import Calibration, read_calibration
from .devices import (
    measured_shapes,
    nominal,
    pushed,
    read_devices,
    stopped,
    tilting,
    unwarmed,
)
from .faults import convert_part, refuse
from .histories import History, read_histories
from .plausible import implausible, proportions, wide
from .quality import damper_of
from .schema import schema_faults, validator
from .shocks import (
    Requirement,
    SpectrumTest,
    Vibration,
    lasts_itself,
    own_points_outside,
    pulse_key,
    read_own_points,
    read_requirements,
    read_shocks,
)
from .tolerances import read_tolerances
from .units import read
from .views import View, choose_boundary, choose_curves, choose_maps
from .yaml_file import ConfigError


@dataclass(frozen=True, eq=False, kw_only=True)
class Config(Study):
    """A study with the cells of its sweep, and what else is made of it.

    grid: all axes, each ascending
    pulse: values for `shocks_of`
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
        settings = self.settings.asked()
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
    faults = schema_faults(document)
    parts = document if isinstance(document, Mapping) else {}
    device = read_devices(parts, faults)
    given = parts.get("sweep")
    pulse = pulse_key(given, ("sweep",), faults, lasts_itself(parts.get("pulse")))
    varied = [key for key in given if key in (*VALUES, "C")] if isinstance(given, Mapping) else []
    push = HANDOUT_SHOCK, {}
    if "pulse" in parts:
        push = convert_part(document, ("pulse",), faults, read_shocks)
    shocks, pulse_values = push or (None, {})
    C = damper_of(parts, device, faults)
    keys = [*varied, *([pulse] if pulse else []), "N"]
    axes = {
        "f0" if key == "duration" else key: convert_part(
            document, ("sweep", key), faults, read_axis, key
        )
        for key in keys
    }
    cells = parts.get("histories")
    for place, cell in enumerate(cells if isinstance(cells, list | tuple) else ()):
        pulse_key(cell, ("histories", place), faults)
    requirements, vibrations, spectra = read_requirements(parts, faults)
    refuse(faults)
    skip = given.get("not_bistable") == "skip"
    if C is not None:
        axes["C"] = np.array([C])
    if "f0" not in axes:
        axes["f0"] = np.array([shocks.own_frequency()])
    grid = convert_part(document, ("sweep",), faults, lambda _: _grid(device, axes, skip, shocks))
    tolerances = None
    if "tolerances" in parts:
        devices = list(device.values()) if isinstance(device, Mapping) else [device]
        at = ("tolerances",)
        tolerances = convert_part(document, at, faults, read_tolerances, devices)
    calibration = None
    if "calibration" in parts:
        given_so = device, shocks, axes["C"]
        at = ("calibration",)
        calibration = convert_part(document, at, faults, read_calibration, *given_so)
    histories = read_histories(document, device, grid, faults)
    own_points = ()
    if "marks" in parts:
        own_points = convert_part(document, ("marks",), faults, read_own_points)
    maps = read_views(document, "maps", faults, grid)
    curves = read_views(document, "thresholds", faults, grid)
    refuse(faults)
    try:
        own = Study(device=device, shocks=shocks)
        if requirements or vibrations or spectra or tolerances:
            own.set_out({})  # they are of the device itself, whatever the axes make of it
        for asked in requirements:
            replace(own, shocks=shocks_of(asked.pulse))
        if vibrations or spectra:
            own.require_frame("a spectrum among the requirements")
    except ValueError as error:
        raise ConfigError(str(error)) from None
    chosen, left_out = choose_maps(grid, nominal(device), maps)
    return Config(
        device=device,
        model=_model(document["model"]),
        grid=grid,
        skip=skip,
        settings=_settings(given),
        shocks=shocks,
        pulse=pulse_values,
        requirements=requirements,
        vibrations=vibrations,
        spectra=spectra,
        tolerances=tolerances,
        calibration=calibration,
        threshold_tolerance=given.get("threshold_tolerance", THRESHOLD_TOLERANCE),
        histories=histories,
        maps=chosen,
        curves=choose_curves(grid, nominal(device), curves),
        boundary=choose_boundary(grid, nominal(device)),
        own_points=own_points,
        left_out=left_out,
        measured=measured_shapes(document),
    )


def _grid(device, axes, skip, shocks):
    remedy = "write other values" if skip else "write other values, or not_bistable: skip"
    try:
        grid = make_grid(device, axes, skip, shocks)
    except ValueError as error:
        at_fault = str(error) if str(error).startswith("device") else f"sweep: {error}; {remedy}"
        raise ValueError(at_fault) from None
    if (grid.device_of < 0).all():
        raise ValueError(f"sweep: no device has a second stable shape; {remedy}")
    return grid


def _model(section):
    formats = validator().schema["properties"]["model"]["properties"]
    return {
        key: read(value, formats[key]["format"]) if "format" in formats[key] else value
        for key, value in section.items()
    }


def _settings(section):
    given = {key: section[key] for key in ("until", "repeat", "energy_tolerance") if key in section}
    given.setdefault("repeat", given.get("until", "settled") == "settled")
    return Settings(horizon=read(section["horizon"], "duration"), **given)
