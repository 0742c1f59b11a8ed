"""Measure every case of a plan against converged runs, whose own error refinement estimates.

Only steps and horizons are held against the finest step and the longest horizon instead.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import xarray as xr

from snapmap.device import Device
from snapmap.io.provenance import device_sections, provenance
from snapmap.solver.settings import Settings

from .answers import ask_all
from .cases import CONVERGED, HARD, list_cases
from .converged import converge
from .dataset import dress
from .plans import Plan
from .probe import make_probe


def measure(
    device: Device,
    axes: Mapping[str, Sequence[float]],
    settings: Settings,
    plan: Plan,
) -> xr.Dataset:
    """Measure every case of a plan on one device; returns a dataset along `model`.

    axes: C, f0 and N of the sweep from whose range the cells are chosen
    settings: with the threads for the thresholds; the map is always timed on one
    """
    probe = make_probe(axes, plan.side)
    settings = settings._replace(until="snap", repeat=False)
    converged = {CONVERGED: converge(device, probe, settings, plan.converged)}
    if math.isfinite(device.contact):
        hard = replace(device, contact=math.inf)
        converged[HARD] = converge(hard, probe, settings, plan.hard)
    cases = list(list_cases(device, settings, plan))
    answers = {name: run.answer for name, run in converged.items()}
    answers |= ask_all(cases, probe)
    document = {
        **device_sections(device),
        "sweep": settings.asked() | {"horizon": f"{settings.horizon!r} us"},
        "accuracy": plan._asdict(),
    }
    return dress(cases, answers, converged, probe).assign_attrs(provenance(document))
