"""The section `calibration`: measured shots, and what is read off them."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..calibration.shots import check_ranges, shots_from
from ..device import Device
from ..io.named import sha256_of
from ..io.recorded import RECORD
from ..io.tables import ROWS, read_shots
from ..shocks import Shocks
from .keys import inside
from .models import CalibrationSection


class Calibration(NamedTuple):
    """What is asked of measured shots.

    shots: path of their table; files: SHA-256 of it and of recorded shocks that it names, by path
    unknowns: ranges by name, internal units; C: uN us/um, unless it is unknown
    """

    shots: str
    files: dict[str, str]
    unknowns: dict[str, list[float]]
    C: float | None


def read_calibration(
    section: CalibrationSection, device: Device | Mapping, shocks: Shocks, C: np.ndarray
) -> Calibration:
    """Take the section; ValueError, one line, for what cannot be.

    shocks: of shots that name none, their first; C: of the sweep, taken if it is one value
    """
    unknowns = {key: list(ends) for key, ends in section.unknowns.given.items()}
    damping = section.C
    if damping is None and "C" not in unknowns and C.size == 1:
        damping = float(C[0])
    if isinstance(device, Mapping):
        raise ValueError("is of one device; write device in place of devices")
    check_ranges(unknowns, damping)
    files = {section.shots: sha256_of(section.shots, *ROWS)}
    for record in read_shots(section.shots).get("file", []):
        if record and record not in files:
            files[inside(record)] = sha256_of(record, *RECORD)
    shots_from(read_shots(section.shots), shocks.first(), device)
    return Calibration(section.shots, files, unknowns, damping)
