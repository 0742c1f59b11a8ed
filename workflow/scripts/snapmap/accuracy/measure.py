"""Measure every case of a plan against converged runs, whose own error refinement estimates.

Only steps and horizons are held against the finest step and the longest horizon instead.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import xarray as xr

from ..config import device_document
from ..device import Device
from ..protocol import Protocol
from ..provenance import provenance
from .answers import ask_all
from .cases import CONVERGED, HARD, list_cases
from .converged import converge
from .dataset import dress
from .plans import Plan
from .probe import make_probe


def measure(
    device: Device,
    axes: Sequence[Sequence[float]],
    protocol: Protocol,
    plan: Plan,
    threads: int = 1,
) -> xr.Dataset:
    """Measure every case of a plan on one device; returns a dataset along `model`.

    axes: of the sweep from whose range the cells are chosen, in the order of `grid.AXES`
    threads: for the thresholds; the map is always timed on one
    """
    probe = make_probe(axes, plan.side)
    protocol = protocol._replace(until="snap", repeat=False)
    converged = {CONVERGED: converge(device, probe, protocol, plan.converged, threads)}
    if math.isfinite(device.contact):
        hard = replace(device, contact=math.inf)
        converged[HARD] = converge(hard, probe, protocol, plan.hard, threads)
    cases = list(list_cases(device, protocol, plan))
    answers = {name: run.answer for name, run in converged.items()}
    answers |= ask_all(cases, probe, threads)
    document = {
        "device": device_document(device),
        "sweep": protocol._asdict() | {"horizon": f"{protocol.horizon!r} us"},
        "accuracy": plan._asdict(),
    }
    return dress(cases, answers, converged, probe).assign_attrs(provenance(document))
