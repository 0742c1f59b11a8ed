"""The verdicts as an xarray dataset along case, model and step."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from snapmap.device import Device
from snapmap.io.provenance import device_sections, provenance
from snapmap.io.variables import variables

from .cases import HARD, Case
from .pairs import FINE_STEPS
from .verdicts import VERDICTS

VARIABLES = {
    "limit": {"long_name": "stability limit of the time step", "units": "us"},
    "outcome": {**variables("cube")["outcome"], "long_name": "outcome of the case's first cell"},
    "energy_error": {
        "long_name": "largest residual of an energy ledger over the gross work of the pulse",
        "units": "1",
        "comment": "inf: a run blew up; NaN: not run",
    },
    "snap_shift": {
        "long_name": "largest difference of a believed snap time from the fine runs', over it",
        "units": "1",
        "comment": "NaN: there are none to compare",
    },
    "verdict": {
        "long_name": "verdict on the worst of the case's cells",
        "flag_values": np.arange(len(VERDICTS), dtype=np.int8),
        "flag_meanings": " ".join(VERDICTS),
    },
    "step": {"long_name": "time step over the stability limit", "units": "1"},
    "halvings": {
        "long_name": "how often the default step was halved until every ledger closed",
        "units": "1",
        "comment": "-1: not run",
    },
}


def dress(
    device: Device,
    cases: Sequence[Case],
    models: Mapping[str, Mapping],
    steps: Sequence[float],
    values: Mapping[str, np.ndarray],
) -> xr.Dataset:
    """Give what was found its axes and CF attributes.

    values: by name, of every pair of case and model, cases first: (pairs,) or (pairs, steps)
    """
    axes = {
        "case": ("case", [case.name for case in cases], {"long_name": "hard case"}),
        "model": ("model", list(models), {"long_name": "model"}),
        "step": ("step", list(steps), VARIABLES["step"]),
    }
    data = {}
    for name, one in values.items():
        shape = (len(cases), len(models), *one.shape[1:])
        kind = float if one.dtype.kind == "f" else np.int8
        attributes = VARIABLES[name.removeprefix("default_")]
        data[name] = (tuple(axes)[: len(shape)], one.reshape(shape).astype(kind), attributes)
    document = {
        **device_sections(device),
        "cases": [_document(case) for case in cases],
        "models": dict(models),
        "fine_steps": FINE_STEPS,
    }
    return xr.Dataset(data, axes).assign_attrs(
        Conventions="CF-1.11", title="Hard cases", **provenance(document)
    )


def _document(case):
    asked = {key: value for key, value in case._asdict().items() if value is not None}
    return {key: "hard" if value == HARD else value for key, value in asked.items()}
