"""The section `calibration`: measured shots, and what is read off them."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..calibration.shots import check_ranges, shots_from
from ..device import Device
from ..io.columns import ROWS
from ..io.named import sha256_of
from ..io.recorded import RECORD
from ..io.shots import read_shots
from ..pulse import Shocks
from ..quantities import QUANTITIES
from .shocks import check_path
from .units import read


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
    section: Mapping, device: Device | Mapping, shocks: Shocks, C: np.ndarray
) -> Calibration:
    """Convert the section; ValueError names what cannot be.

    shocks: of shots that name none, their first; C: of the sweep, taken if it is one value
    """
    unknowns = {
        key: [read(end, QUANTITIES[key].kind) for end in ends]
        for key, ends in section["unknowns"].items()
    }
    damping = None
    if "C" in section:
        damping = read(section["C"], "damper")
    elif "C" not in unknowns and C.size == 1:
        damping = float(C[0])
    try:
        if isinstance(device, Mapping):
            raise ValueError("is of one device; write device in place of devices")
        check_ranges(unknowns, damping)
        files = _files(section["shots"])
        shots_from(read_shots(section["shots"]), shocks.first(), device)
    except ValueError as error:
        raise ValueError(f"calibration: {error}") from None
    return Calibration(section["shots"], files, unknowns, damping)


def _files(path):
    """SHA-256 of a table of shots and of the records that it names."""
    check_path(path)
    files = {path: sha256_of(path, *ROWS)}
    for record in read_shots(path).get("file", []):
        if record and record not in files:
            check_path(record)
            files[record] = sha256_of(record, *RECORD)
    return files
