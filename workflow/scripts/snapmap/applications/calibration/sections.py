"""The section `calibration`: measured shots, and the unknowns that they determine."""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np

from ...config.kinds import StudyPath
from ...device.device import VALUES, Device
from ...files.named import inside, sha256_of
from ...files.tables import ROWS
from ...pulse.pulse import N_of_g
from ...pulse.recorded import RECORD
from ...pulse.shocks import Shocks
from ...study.axes import KIND_OF
from ...values.kinds import Pair
from ...values.quantities import Damper
from ...values.records import record, row_of_kinds, told
from .shots import Shots, check_ranges, read_shots, shots_from


def _range(key):
    return Annotated[
        tuple, Pair(KIND_OF[key])
    ], "range of an unknown, a pair of values; known if left out"


@record
class UnknownsSection(row_of_kinds("Ranges", {key: _range(key) for key in (*VALUES, "C")})):
    """One to four values of the device, or C, with the range of each."""


@record
class CalibrationSection:
    """Values estimated from measured shots."""

    shots: StudyPath
    """a CSV table: N, f0 (Hz) or duration (ms), tripped (yes, no), optionally direction, shape,
    file (a record)"""
    unknowns: UnknownsSection
    """one to four values of the device, or C, with the range of each"""
    C: Damper | None = None
    """damping of the mass in the shots; unknown, or that of `sweep`, if left out"""


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
    unknowns = {key: list(ends) for key, ends in told(section.unknowns).items()}
    damping = section.C
    if damping is None and "C" not in unknowns and C.size == 1:
        damping = float(C[0])
    if isinstance(device, Mapping):
        raise ValueError("needs a single device; write device instead of devices")
    check_ranges(unknowns, damping, device)
    files = {section.shots: sha256_of(section.shots, *ROWS)}
    table = read_shots(section.shots, files[section.shots], N_of_g(device.gravity))
    for file in table.get("file", []):
        if file and file not in files:
            files[file] = sha256_of(inside(file), *RECORD)
    shots = shots_from(table, shocks.first(), device)
    return Calibration(shots, files, unknowns, damping)
