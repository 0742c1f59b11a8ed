"""The section `calibration`: measured shots, and the unknowns that they determine."""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from ...config.devices import of_device
from ...config.keys import Section, inside, part, path, quantity, words
from ...device.device import Device
from ...device.quantities import KINDS
from ...files.named import sha256_of
from ...files.tables import ROWS
from ...pulse.pulse import N_of_g
from ...pulse.recorded import RECORD
from ...pulse.shocks import Shocks
from .shots import Shots, check_ranges, read_shots, shots_from


def _span(name, kind, example=""):
    """Make the type of the range of an unknown."""
    need = f"a pair of values: its range, each {KINDS[kind].name}"
    return Annotated[tuple[quantity(kind), quantity(kind)], words(need, "", example, "it is known")]


class UnknownsSection(of_device(_span)):
    """One to four values of the device, or C, with the range of each."""

    C: _span("C", "damper", "[1 uN*us/um, 100 uN*us/um]")


class CalibrationSection(Section):
    """Values estimated from measured shots."""

    shots: path(
        "a CSV table in the study's folder: N, f0 (Hz) or duration (ms), tripped (yes, no), "
        "optionally direction, shape, file (a record)",
        "shots.csv",
    )
    unknowns: part(UnknownsSection)
    C: quantity("damper", "damping of the mass in the shots", out="unknown, or that of `sweep`")


class Calibration(NamedTuple):
    """Measured shots and the unknowns to estimate from them.

    files: SHA-256 of the table of shots and of the records that it names, by path
    unknowns: ranges by name, internal units; C: uN us/um, or None if it is unknown
    """

    shots: Shots
    files: dict[str, str]
    unknowns: dict[str, list[float]]
    C: float | None


def read_calibration(
    section: CalibrationSection, device: Device | Mapping, shocks: Shocks, C: np.ndarray
) -> Calibration:
    """Take the section; raises ValueError, one line, for invalid ones.

    shocks: the first is the default of shots; C: of the sweep; a single value is the default
    """
    unknowns = {key: list(ends) for key, ends in section.unknowns.given.items()}
    damping = section.C
    if damping is None and "C" not in unknowns and C.size == 1:
        damping = float(C[0])
    if isinstance(device, Mapping):
        raise ValueError("needs a single device; write device instead of devices")
    check_ranges(unknowns, damping, device)
    files = {section.shots: sha256_of(section.shots, *ROWS)}
    table = read_shots(section.shots, files[section.shots], N_of_g(device.gravity))
    for record in table.get("file", []):
        if record and record not in files:
            files[record] = sha256_of(inside(record), *RECORD)
    shots = shots_from(table, shocks.first(), device)
    return Calibration(shots, files, unknowns, damping)
