"""A forecast of the core time of devices as made."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...device.device import batch
from ...device.samples import Tolerances
from ...solver.adaptive import choose_survey
from ...solver.cells import to_rows
from ...solver.cost import steps_and_seconds
from ...study.shock import Shock
from ...study.study import Study
from ...thresholds.cost import run_seconds
from ...thresholds.probe import Probe

PER_ROW, PER_SAMPLE = 3000, 3
"""Approximate numbers of runs: to bracket the thresholds of a row, and to find that of a sample."""


def made_seconds(
    study: Study,
    axes: Mapping[str, np.ndarray],
    tolerances: Tolerances,
    requirements: Sequence[Shock] = (),
) -> float:
    """Forecast the core time of `tolerances_of`, s."""
    pulse = np.arange(len(study.shocks.pulses))[:, np.newaxis, np.newaxis]
    rows = to_rows(0, axes["f0"], axes["C"][:, np.newaxis], pulse, study.shocks.pulses)
    every = tolerances.samples + tolerances.power * (1 + len(tolerances.scatters))
    seconds = 0.0
    for device in study.devices().values():
        model = choose_survey(batch([device]), study.model).decides
        seconds += _of_rows(Probe(model, rows, study.run), every)
        if device.beam.damping > 0:
            cells = rows.cells(model.device, axes["N"], study.horizon)
            _, to_end = steps_and_seconds(model, cells, study.run)
            seconds += tolerances.followed(to_end.size) * float(to_end.sum())
        for required in requirements:
            shock = to_rows(0, required.f0, axes["C"], 0, required.shocks.pulses)
            settings = required.shaken(study).run
            cells = shock.cells(model.device, required.N, settings.horizon)
            _, to_end = steps_and_seconds(model, cells, settings.but(until="settled"))
            _, moving = steps_and_seconds(model, cells, settings.but(until="moved"))
            of_sample = (required.snaps is True) * to_end + (device.strength < np.inf) * moving
            judged = _of_rows(Probe(model, shock, settings), tolerances.samples)
            judged += tolerances.samples * float(of_sample.sum())
            seconds += judged * len(axes.get("temperature", [0]))
    return seconds


def _of_rows(probe, samples):
    runs = PER_ROW + PER_SAMPLE * samples
    return runs * float(run_seconds(probe).sum())
