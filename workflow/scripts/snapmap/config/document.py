"""The sections of the core in a config, but for device and shock."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

from ..files.named import sha256_of
from ..files.tables import ROWS
from ..files.text import describe
from ..solver.options import Model
from ..solver.settings import THRESHOLD_TOLERANCE, Run
from ..study.arguments import AxesOfDevice
from ..study.axes import COORDINATES, KIND_OF
from ..values.arguments import one_time
from ..values.kinds import Several, Word, kind_of
from ..values.quantities import (
    Amplitudes,
    Dampers,
    Frequencies,
    PulseTimes,
    Refinement,
    Title,
    Truth,
)
from ..values.records import record
from .devices import DeviceSection
from .kinds import PATH
from .points import read_points
from .shocks import PULSE, TIMED, PulseSection

AXES = [*(name for name in COORDINATES if name not in ("C", "f0", "N")), "C", "f0", "duration", "N"]
"""Names of axes of figures."""
OF_SNAKEMAKE = "threads"
"""The value of a run that no config has."""


Axis = Annotated[str, Word((*AXES,), "the name of an axis")]
AxisOfThresholds = Annotated[str, Word((*AXES[:-1],), "the name of an axis other than N")]


@record
class MapSection:
    """A map over two axes."""

    x: Axis
    """horizontal axis"""
    y: Axis
    """vertical axis; a map without N shows thresholds"""
    at: dict[str, object] | None = None
    """values on other axes, each rounded to the nearest there; left out, an axis takes the device's
    own value, else its middle, and N takes none"""


@record
class LinesSection:
    """A figure of thresholds over two axes."""

    x: AxisOfThresholds
    """horizontal axis"""
    lines: AxisOfThresholds
    """each value is a line"""
    at: dict[str, object] | None = None
    """as in maps"""


@record
class SweepSection(AxesOfDevice):
    """The axes: a list, or a range with both ends, of each."""

    elsewhere = dict.fromkeys(PULSE, "; write it under pulse")
    N: Amplitudes | None = None
    """peaks of the shock over gravity"""
    f0: Frequencies | None = None
    """1/duration of the shock; required, or `duration`, or a pulse that has its own"""
    duration: PulseTimes | None = None
    """durations of the shock; replaces f0"""
    C: Dampers | None = None
    """damping of the mass; required, or `device.quality_factor`, or no mass"""
    threshold_tolerance: Refinement = THRESHOLD_TOLERANCE
    """relative step of N at which the search for a threshold ends"""

    @classmethod
    def beside(cls, written: Mapping) -> dict[str, str]:
        """Find N missing."""
        return {} if "N" in written else {"N": f"missing; write {Several(KIND_OF['N']).asks}"}


def _marks(path):
    """Read a table of points to check it; gives its path and SHA-256."""
    path = PATH.by(path)
    sha256 = sha256_of(path, *ROWS)
    read_points(path, sha256)
    return path, sha256


Marks = Annotated[tuple[str, str], replace(PATH, by=_marks)]


@record
class Core:
    """Device (or devices), model and sweep; the others are optional."""

    title: Title | None = None
    """head of the data sheet"""
    device: DeviceSection | None = None
    """beam, mass and spring; required, or `devices`"""
    devices: dict[str, DeviceSection] | None = None
    """devices by name, which are an axis"""
    model: Model = None
    """how a cell is simulated"""
    pulse: PulseSection | None = None
    """the shock; a versed sine along +z if left out"""
    run: Run = Run()
    """how each cell is followed"""
    skip: Truth = False
    """whether points without a second stable shape are left out; else they are refused"""
    sweep: SweepSection | None = None
    """the axes"""
    maps: list[MapSection] | None = None
    """maps {x, y, at}; left out, N over f0 at each point of the other axes, at most 12"""
    thresholds: list[LinesSection] | None = None
    """figures {x, lines, at} of thresholds; left out, one over each axis, with a line for each
    device or C"""
    marks: Marks | None = None
    """a CSV table of points on maps: N, f0 (Hz) or duration (ms), optionally name, snapped (yes,
    no)"""

    @classmethod
    def beside(cls, written: Mapping) -> dict:
        """Find sections and keys that are missing, or that exclude others."""
        needs = {"model": kind_of(Model).asks, "sweep": "a mapping: the axes"}
        faults = {
            key: f"missing; write {need}" for key, need in needs.items() if key not in written
        }
        several = written.get("devices")
        if "device" not in written and several is None:
            faults["device"] = "missing; write a mapping: the beam, the mass and what they meet"
        elif "device" in written and several is not None:
            faults["devices"] = "excludes device; write one of them"
        several = several if isinstance(several, Mapping) else {}
        for name in several:
            if not (isinstance(name, str) and re.fullmatch(r"[^\W\d_][\w-]{0,30}", name)):
                need = "a name of letters, digits, - and _, at most 31 of them"
                faults["devices", name] = f"{describe(name)} is not {need}"
        if isinstance(run := written.get("run"), Mapping) and OF_SNAKEMAKE in run:
            faults["run", OF_SNAKEMAKE] = "is given to Snakemake, as --cores; leave it out"
        if isinstance(sweep := written.get("sweep"), Mapping):
            pulse = written.get("pulse")
            itself = isinstance(pulse, Mapping) and any(name in pulse for name in TIMED)
            faults |= {("sweep", key): line for key, line in one_time(sweep, itself).items()}
            faults |= _dampers(written, sweep, several)
        return faults

    @property
    def by_name(self) -> dict[str, DeviceSection]:
        """The sections of the devices; a single one is called `device`."""
        return self.devices or {"device": self.device}


def _dampers(written, sweep, several):
    """Find what is wrong with C, which stands under sweep or follows from the quality factors."""
    at = {("devices", name): device for name, device in several.items()}
    at = at or {("device",): written.get("device")}
    at = {path: device for path, device in at.items() if isinstance(device, Mapping)}
    if at and all(device.get("mass") == "none" for device in at.values()):
        extra = {("sweep", "C"): "needs a mass; leave it out"}
        return extra if "C" in sweep else {}
    factors = [(*path, "quality_factor") for path in at if "quality_factor" in at[path]]
    if "C" in sweep:
        return dict.fromkeys(factors, "replaces sweep.C; write one of them")
    wanted = "dampers (force time per length) of the mass, or device.quality_factor"
    return {} if factors else {("sweep", "C"): f"missing; write {wanted}"}
