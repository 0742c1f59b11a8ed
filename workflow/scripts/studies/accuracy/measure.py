"""Measure every case of a plan against converged runs, whose own error refinement estimates.

Only steps and horizons are held against the finest step and the longest horizon instead.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import xarray as xr

from snapmap.device import Device
from snapmap.io.provenance import device_sections, provenance
from snapmap.pulse import HANDOUT_SHOCK, Shocks
from snapmap.solver.settings import Settings

from .answers import ask_all
from .budget import afford
from .cases import CONVERGED, HARD, list_cases
from .converged import converge
from .dataset import dress
from .plans import Plan
from .probe import look, make_probe


def measure(
    device: Device,
    axes: Mapping[str, Sequence[float]],
    settings: Settings,
    plan: Plan,
    shocks: Shocks = HANDOUT_SHOCK,
) -> xr.Dataset:
    """Measure every case of a plan on one device; returns a dataset along `model`.

    axes: C, f0 and N of the sweep from whose range the cells are chosen
    settings: with the threads for the thresholds; the map is always timed on one
    shocks: of the study
    What the device does not afford is cut down, and `left_out` says so.
    """
    settings = settings._replace(until="edge", repeat=False)
    axes, settings, plan, left_out, slowest = afford(device, axes, settings, plan, shocks)
    probe = make_probe(device, axes, settings, plan, shocks, slowest)
    converged = {CONVERGED: converge(device, probe, settings, plan.converged)}
    if math.isfinite(device.contact):
        hard = replace(device, contact=math.inf)
        N, clean = look(hard, probe.rows, settings, plan.judges)
        of_hard = probe._replace(N=N, clean=clean)
        converged[HARD] = converge(hard, of_hard, settings, plan.hard)
    cases = list(list_cases(device, settings, plan))
    answers = {name: run.answer for name, run in converged.items()}
    answers |= ask_all(cases, probe)
    document = {
        **device_sections(device),
        **shocks.section(),
        "sweep": settings.asked() | {"horizon": f"{settings.horizon!r} us"},
        "accuracy": plan._asdict(),
    }
    found = dress(cases, answers, converged, probe)
    return found.assign_attrs(left_out="; ".join(left_out), **provenance(document))
