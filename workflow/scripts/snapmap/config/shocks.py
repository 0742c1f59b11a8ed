"""The shocks of a config: its pulse, the required shocks, a user's own points."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from ..io.columns import ROWS
from ..io.named import sha256_of
from ..io.points import read_points
from ..io.recorded import RECORD, shocks_of
from ..pulse import SHARES, Shocks
from ..quantities import QUANTITIES
from ..spectra.psd import REACH, Spectrum
from ..spectra.srs import check_points
from ..trains import MAKERS
from .axes import frequency_of
from .faults import Faults, Place, convert_part
from .schema import name_of
from .units import read, show

WHOLE = ("file", *MAKERS)
"""Keys of shocks that are more than a shape, and last as long as they last."""
OF_SPECTRA = {"psd": ("duration", "probability"), "srs": ("direction",)}
"""What may stand beside a spectrum."""
LEVELS = {"psd": ("density", "g^2/Hz", "0.04"), "srs": ("level", "g", "1500")}
"""What a spectrum has at its frequencies: name, unit and an example."""
KINDS_IN_TRAINS = {
    **dict.fromkeys(SHARES, "share"),
    **dict.fromkeys(("N", "rebound"), "number"),
    **dict.fromkeys(("duration", "wait"), "pulse"),
    **dict.fromkeys(("from", "to"), "frequency"),
    "height": "length",
}
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


class Vibration(NamedTuple):
    """Random vibration that must or must not trip the device.

    psd: pairs of Hz and g^2/Hz; duration: s; snaps: whether it must, but for `probability`
    """

    name: str
    psd: list[list[float]]
    duration: float
    snaps: bool
    probability: float


class SpectrumTest(NamedTuple):
    """A shock response spectrum whose records must or must not trip the device.

    srs: pairs of Hz and multiples of g; snaps: whether all must, or none
    """

    name: str
    srs: list[list[float]]
    direction: str
    snaps: bool


def lasts_itself(section: object) -> bool:
    """Whether the shock of a section has a duration of its own."""
    return isinstance(section, Mapping) and any(key in section for key in WHOLE)


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
    whole = next((key for key in WHOLE if key in section), "")
    others = ("shape", *SHARES, *WHOLE) if whole else ()
    if beside := next((key for key in others if key in section and key != whole), None):
        raise ValueError(f"pulse.{beside}: stands beside {whole}; write one of them")
    if whole == "file":
        try:
            check_path(section["file"])
            values["sha256"] = sha256_of(section["file"], *RECORD)
            return shocks_of(values), values
        except ValueError as error:
            raise ValueError(f"pulse.file: {error}") from None
    return shocks_of(values), values


def _pulse_values(section):
    keys = [key for key in ("shape", *SHARES, *WHOLE, "direction") if key in section]
    return {key: _plain(section[key], key) for key in keys}


def _plain(value, key):
    """The value of a key of a shock in internal units, and all that is in it."""
    if isinstance(value, Mapping):
        return {name: _plain(one, name) for name, one in value.items()}
    if isinstance(value, list | tuple) and key in MAKERS:
        return [_plain(one, "") for one in value]
    return read(value, KINDS_IN_TRAINS[key]) if key in KINDS_IN_TRAINS else value


def read_requirements(
    document: Mapping, faults: Faults
) -> tuple[tuple[Requirement, ...], tuple[Vibration, ...], tuple[SpectrumTest, ...]]:
    """Read what must or must not trip the device, by its kind; names are written once."""
    of_spectra = {"psd": _vibration, "srs": _spectrum_test}
    asked = document.get("requirements")
    found, names = [], set()
    for place, section in enumerate(asked if isinstance(asked, list | tuple) else ()):
        path = ("requirements", place)
        keys = [key for key in of_spectra if isinstance(section, Mapping) and key in section]
        if not keys:
            pulse_key(section, path, faults, lasts_itself(section))
        read_one = of_spectra[keys[0]] if keys else _requirement
        found.append(convert_part(document, path, faults, _named, path, names, read_one))
    kinds = Requirement, Vibration, SpectrumTest
    return tuple(tuple(one for one in found if isinstance(one, kind)) for kind in kinds)


def _named(section, path, names, read_one):
    name = section["name"]
    if name in names:
        raise ValueError(f"{name_of((*path, 'name'))}: {show(name)} comes twice; write another")
    names.add(name)
    try:
        return read_one(section, name)
    except ValueError as error:
        raise ValueError(f"{name_of(path)}: {error}") from None


def _vibration(section, name):
    psd = _points(section, "psd")
    if "duration" not in section:
        raise ValueError("duration: missing; write a time such as '3 min'")
    Spectrum(psd)
    duration = 1e-6 * read(section["duration"], "pulse")
    chance = read(section["probability"], "share") if "probability" in section else REACH
    return Vibration(name, psd, duration, section["snaps"], chance)


def _spectrum_test(section, name):
    srs = _points(section, "srs")
    check_points(srs)
    return SpectrumTest(name, srs, section.get("direction", "+z"), section["snaps"])


def _points(section, key):
    """The pairs of a spectrum that stands alone."""
    beside = [other for other in section if other not in ("name", "snaps", key, *OF_SPECTRA[key])]
    if beside:
        raise ValueError(f"{beside[0]}: stands beside {key}; leave it out")
    return [[read(f, "frequency"), _level(value, key)] for f, value in section[key]]


def _level(value, key):
    word, unit, example = LEVELS[key]
    number, _, own = str(value).strip().partition(" ")
    if own.replace("²", "^2").replace("**", "^") != unit:
        told = f"{show(value)} is no {word}; write one such as '{example} {unit}'"
        raise ValueError(f"{key}: {told}")
    return read(number, "number")


def _requirement(section, name):
    shocks, pulse = read_shocks(section)
    keys = [key for key in ("f0", "duration") if key in section]
    given = {key: read(section[key], QUANTITIES[key].kind) for key in keys}
    f0 = frequency_of(given["duration"]) if "duration" in given else given.get("f0")
    own_N = shocks.pulse.own_N
    if own_N is None and "N" not in section:
        raise ValueError("N: missing; write a plain number of gravities > 0")
    N = read(section["N"], "number") if "N" in section else own_N
    if not N > 0:
        raise ValueError(f"N: {N:g} is not above 0; a direction of -z pushes the other way")
    survives = _survives(section.get("survives", True))
    own = f0 or shocks.own_frequency()
    return Requirement(name, pulse, N, own, section["snaps"], survives)


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
        check_path(path)
        sha256 = sha256_of(path, *ROWS)
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


def check_path(path: str) -> None:
    """Raise ValueError, one line, for a path out of the study's folder."""
    if PurePath(path).is_absolute() or ".." in PurePath(path).parts:
        raise ValueError(f"{path} lies outside the study's folder; copy it there")
