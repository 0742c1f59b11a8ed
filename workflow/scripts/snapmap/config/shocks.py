"""The shocks of a config: its pulse, the required shocks, a user's own points."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from ..io.named import sha256_of
from ..io.points import POINTS, read_points
from ..io.recorded import RECORD, shocks_of
from ..pulse import Shocks
from ..quantities import QUANTITIES
from .axes import frequency_of
from .faults import Faults, Place, convert_part
from .schema import name_of
from .units import read, show

SHARES = ("rise", "fall")
"""Of a trapezoid, over its duration."""
# ASSUME: of devices whose strengths scatter all but one in a thousand must survive.
SURVIVES = 0.999


class Requirement(NamedTuple):
    """A shock that must or must not trip the device.

    pulse: values for `shocks_of`; N: multiples of g; f0: Hz; snaps: whether it must
    survives: the least probability with which its beam must not break; 0 if it may
    """

    name: str
    pulse: dict
    N: float
    f0: float
    snaps: bool
    survives: float


def pulse_key(section: object, path: Place, faults: Faults, recorded: bool = False) -> str:
    """Which of f0 and duration the section at `path` has; a fault unless it is one of them.

    recorded: whether it may have neither, as a recorded shock has a duration of its own; then ""
    """
    if not isinstance(section, Mapping) or ("f0" in section) != ("duration" in section):
        return "duration" if isinstance(section, Mapping) and "duration" in section else "f0"
    if "f0" in section:
        key, complaint = "duration", "is one over f0, which is there, too; write one of them"
    elif recorded:
        return ""
    else:
        key, complaint = "f0", "missing; write frequencies (1/time), or duration"
    faults[(*path, key)] = f"{name_of((*path, key))}: {complaint}"
    return "f0"


def read_shocks(section: Mapping) -> tuple[Shocks, dict]:
    """Read the shocks of a section with shape or file, and their values for `shocks_of`.

    Values hold the SHA-256 of a file. Raises ValueError, one line.
    """
    values = _pulse_values(section)
    if "file" in section:
        beside = next((key for key in ("shape", "rise", "fall") if key in section), None)
        if beside:
            raise ValueError(f"pulse.{beside}: stands beside file; write one of them")
        try:
            _check_path(section["file"])
            values["sha256"] = sha256_of(section["file"], *RECORD)
            return shocks_of(values), values
        except ValueError as error:
            raise ValueError(f"pulse.file: {error}") from None
    return shocks_of(values), values


def _pulse_values(section):
    keys = [key for key in ("shape", "rise", "fall", "file", "direction") if key in section]
    return {key: read(section[key], "share") if key in SHARES else section[key] for key in keys}


def read_requirements(document: Mapping, faults: Faults) -> tuple[Requirement, ...]:
    """Read what must or must not trip the device; names are written once."""
    asked = document.get("requirements")
    found, names = [], set()
    for place, section in enumerate(asked if isinstance(asked, list | tuple) else ()):
        path = ("requirements", place)
        recorded = isinstance(section, Mapping) and "file" in section
        pulse_key(section, path, faults, recorded)
        found.append(convert_part(document, path, faults, _requirement, path, names))
    return tuple(found)


def _requirement(section, path, names):
    name = section["name"]
    if name in names:
        raise ValueError(f"{name_of((*path, 'name'))}: {show(name)} comes twice; write another")
    names.add(name)
    try:
        shocks, pulse = read_shocks(section)
        keys = [key for key in ("f0", "duration") if key in section]
        given = {key: read(section[key], QUANTITIES[key].kind) for key in keys}
        f0 = frequency_of(given["duration"]) if "duration" in given else given.get("f0")
        N = read(section["N"], "number")
        if not N > 0:
            raise ValueError(f"N: {N:g} is not above 0; a direction of -z pushes the other way")
        survives = _survives(section.get("survives", True))
        own = f0 or shocks.own_frequency()
        return Requirement(name, pulse, N, own, section["snaps"], survives)
    except ValueError as error:
        raise ValueError(f"{name_of(path)}: {error}") from None


def _survives(given):
    if isinstance(given, bool):
        return SURVIVES if given else 0.0
    try:
        return read(given, "share")
    except ValueError as error:
        raise ValueError(f"survives: {error}") from None


def read_own_points(path: str) -> tuple[str, str]:
    """Path and SHA-256 of a user's own points, all in order; else ValueError, one line."""
    try:
        _check_path(path)
        sha256 = sha256_of(path, *POINTS)
        read_points(path, sha256)
    except ValueError as error:
        raise ValueError(f"marks: {error}") from None
    return path, sha256


def own_points_outside(path: str, axes: Mapping[str, np.ndarray]) -> list[str]:
    """A line for each of a user's own points that lies on no map."""
    lines = []
    for number, point in enumerate(read_points(path), start=1):
        for key, value in (("f0", point.f0), ("N", point.N)):
            low, high = axes[key].min(), axes[key].max()
            if not low <= value <= high:
                place = f"{key} = {value:g}, maps from {low:g} to {high:g}"
                who = f"{path}: {point.name or f'point {number}'}"
                lines.append(f"{who} lies on no map: {place}")
    return lines


def _check_path(path):
    if PurePath(path).is_absolute() or ".." in PurePath(path).parts:
        raise ValueError(f"{path} lies outside the study's folder; copy it there")
