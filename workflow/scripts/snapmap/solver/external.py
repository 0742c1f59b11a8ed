"""Cells followed by a user's own solver, a function of one cell or of several."""

import inspect
import json
import logging
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..device.device import Device
from ..files.named import naming
from ..files.text import show
from ..pulse.pulse import Pulse
from .cells import Cells
from .laws import Laws, fault_of, of_user
from .settings import Run

logger = logging.getLogger("snapmap")
LANES = 1  # cells that are followed side by side
TOGETHER = 256
"""Most cells of a call to a solver that takes several: those of a call that ends early are lost."""
HEAD = b"N,f0 (Hz),C,step (us),t_snap (us),hash of all that the run depends on"
LINE = re.compile(rb"(?:[^,]+,){4}([-+.e\d]+|nan|inf),([0-9a-f]{16})")
"""A line of a file of runs; its end tells that it is whole."""


class Cell(NamedTuple):
    """A single cell for a solver, with the units of `Cells` and the start of `Run`."""

    device: Device
    pulse: Pulse
    amplitude: float
    f0: float
    damping: float
    t_end: float
    start: str

    def acceleration(self, t: np.ndarray | float) -> np.ndarray:
        """Return the acceleration of the frame along +z, um/us^2, at times, us, of any shape."""
        return self.amplitude * self.pulse.at(np.asarray(self.f0 * t))

    @property
    def place(self) -> tuple[float, float, float]:
        """N, f0 in Hz, and C."""
        return float(self.amplitude / self.device.gravity), 1e6 * self.f0, self.damping


class Answers:
    """A user's own solver and its answers, in memory and in a file, so that no run is made twice.

    together: most cells that the solver takes in one call
    """

    def __init__(self, solver: Callable, laws: Laws):
        """Take a solver and its laws, and read the runs that their file has kept."""
        self.solver, self.laws, self.known = solver, laws, dict[str, float]()
        takes_several = next(iter(inspect.signature(solver).parameters)) == "cells"
        self.together = TOGETHER if takes_several else 1
        if laws.kept:
            with naming(laws.kept):
                self._read(Path(laws.kept))

    def __call__(self, cells: Sequence[Cell], steps: Sequence[float]) -> list[float]:
        """Return t_snap of cells, us: NaN for no snap, inf for a run not to trust."""
        keys = [self._key(*run) for run in zip(cells, steps, strict=True)]
        new = [i for i, key in enumerate(keys) if key not in self.known]
        for at in np.split(new, range(self.together, len(new), self.together)) if new else []:
            part = [cells[i] for i in at]
            answers = self._ask(part, [steps[i] for i in at])
            self.known |= {keys[i]: t for i, t in zip(at, answers, strict=True)}
            if self.laws.kept:
                runs = (
                    (*map(repr, (*cells[i].place, steps[i], self.known[keys[i]])), keys[i])
                    for i in at
                )
                with naming(self.laws.kept):
                    lines = "".join(f"{','.join(run)}\n" for run in runs)
                    _append(Path(self.laws.kept), lines.encode())
        return [self.known[key] for key in keys]

    def _ask(self, cells, steps):
        """Run the solver; ValueError, one line with its name and N, f0, C, if that goes wrong."""
        name = self.laws.file or getattr(self.solver, "__name__", "solver")
        N, f0, C = cells[0].place
        where = f"{name} at N = {N:.10g}, f0 = {f0:.10g} Hz, C = {C:.10g} {self.laws.unit_of_C}"
        where = where.rstrip()
        where += f" and {len(cells) - 1} other cells" if len(cells) > 1 else ""
        with of_user(where):
            if self.together == 1:
                answers = [self.solver(cells[0], steps[0])]
            else:
                answers = list(self.solver(cells, steps))
        try:
            if len(answers) != len(cells):
                raise ValueError(f"returns {len(answers)} times; return one for each cell")
            return [_time_of(answer) for answer in answers]
        except ValueError as error:
            raise fault_of(self.solver, where, str(error)) from None

    def _key(self, cell, step):
        """Hash what a run depends on: the solver's file, device, pulse, cell and step."""
        parts = self.laws.sha256, asdict(cell.device), cell[2:], step
        plain = json.dumps(parts, default=np.ndarray.tolist).encode()
        return blake2b(plain + cell.pulse.pieces.tobytes(), digest_size=8).hexdigest()

    def _read(self, path):
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_bytes().split(b"\n") if path.exists() else [b""]
        runs = [LINE.fullmatch(line) for line in lines]
        self.known |= {run[2].decode(): float(run[1]) for run in runs if run}
        if lines == [b""]:
            _append(path, HEAD + b"\n")
        elif lines[-1]:  # a run was killed while it wrote
            _append(path, b"\n")
        whole = sum(map(bool, runs)) + lines.count(b"") + lines.count(HEAD)
        if damaged := len(lines) - whole:
            logger.warning("%s: left out damaged lines, %d in all", path, damaged)


def _append(path, content):
    with open(path, "ab", buffering=0) as file:  # whole, beside other jobs
        file.write(content)


def march(model, cells: Cells, dt: np.ndarray, settings: Run) -> tuple[np.ndarray, ...]:
    """Follow cells by the `Answers` of a model; takes and returns what `plain_loop.march` does.

    The solver takes a `Cell` and a step, us, or lists of these if its first parameter is `cells`.
    """
    columns = zip(*(column.tolist() for column in cells[2:-1]), strict=True)
    devices = [model.pick(i).device for i in cells.device.tolist()]
    pulses = (cells.pulses[i] for i in cells.pulse.tolist())
    alone = [
        Cell._make((device, pulse, *values, settings.start))
        for device, pulse, values in zip(devices, pulses, columns, strict=True)
    ]
    t_snap = np.array(model.answers(alone, dt.tolist()))
    lost, unknown = np.where(np.isinf(t_snap), np.inf, 0.0), np.full(dt.size, np.nan)
    return t_snap, unknown, np.zeros(dt.size, np.int8), lost, unknown, unknown, unknown


def _time_of(answer: object) -> float:
    """Convert the answer of a solver to a time, us, or NaN; raises ValueError for a wrong one."""
    if answer is None:
        return np.nan
    numbers = int | float | np.integer | np.floating
    if isinstance(answer, bool) or not isinstance(answer, numbers) or not answer >= 0:
        needs = "return the time of the snap (us), None for no snap, or inf for a run not to trust"
        raise ValueError(f"returns {show(answer)}; {needs}")
    return float(answer)
