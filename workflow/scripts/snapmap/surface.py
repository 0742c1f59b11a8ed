"""The threshold surface over damping and frequency as an xarray dataset."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from .cells import check_cells
from .config import device_document
from .cube import COORDINATES
from .device import Device
from .ladder import choose_model
from .protocol import THRESHOLD_TOLERANCE, Protocol, check_number, check_protocol
from .provenance import provenance
from .statics import static_threshold
from .survey import survey

IMPULSE = 100.0
"""A pulse of this many times the mass's own frequency is as good as a jump in velocity."""

MULTIPLES = {"units": "1", "comment": "in multiples of g"}
VARIABLES = {
    "N_first": {"long_name": "lowest amplitude that snaps", **MULTIPLES},
    "N_error": {"long_name": "uncertainty of N_first from space, time and refinement", **MULTIPLES},
    "N_always": {"long_name": "lowest amplitude above which all snap", **MULTIPLES},
    "N_pulse": {"long_name": "lowest amplitude that snaps while the pulse lasts", **MULTIPLES},
    "t_snap": {
        "long_name": "time of the snap at N_first",
        "units": "us",
        "comment": "counted from the start of the pulse",
    },
    "islands": {"long_name": "number of stretches of N below N_always that snap", "units": "1"},
    "island_from": {"long_name": "lowest amplitude of an island", **MULTIPLES},
    "island_to": {"long_name": "highest amplitude of an island", **MULTIPLES},
    "N_static": {"long_name": "threshold of a pulse of any length, quasi-static", **MULTIPLES},
    "velocity_change": {"long_name": "threshold of a jump in velocity", "units": "um us-1"},
}


def threshold(
    device: Device,
    f0: Sequence[float],
    C: Sequence[float],
    horizon: float = 1500.0,
    model: str | Mapping = "auto",
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
    energy_tolerance: float = 1e-3,
    threads: int = 1,
    **options,
) -> xr.Dataset:
    """Find where snapping begins over C (uN us/um) and f0 (Hz), with error bars.

    horizon: us followed after the pulse; tolerance: of the refinement in N, relative
    highest: up to which N islands are looked for; twice the threshold if not given
    energy_tolerance: as in `Protocol`
    model, options: as in the config's model section, or as a mapping the whole of it, which may
        give `auto` a tolerance of its own
    The variables are those of `survey.Survey`, (C, f0), and the limits for slow and short pulses:
    N_static and velocity_change, (C).

    >>> device = snapmap.load_device("config/config.yaml")
    >>> found = snapmap.threshold(device, [1500], [25], model="cosines")
    >>> found.N_first.round().item()
    990.0
    """
    protocol = Protocol(horizon, energy_tolerance=energy_tolerance)
    _check(f0, C, tolerance, highest, protocol)
    model = {"name": model, **options} if isinstance(model, str) else dict(model)
    chosen = choose_model(device, **model)
    C, f0 = (np.atleast_1d(np.asarray(values, float)) for values in (C, f0))
    impulse = IMPULSE * np.sqrt(device.spring / device.mass) / (2 * np.pi) * 1e6

    def look(f0):
        rows = (values.ravel() for values in np.meshgrid(f0, C))
        return survey(chosen, *rows, protocol, tolerance, threads, highest)

    found = look(f0)._asdict()
    shape = C.size, f0.size
    data = {
        key: (("C", "f0", "island")[: values.ndim + 1], values.reshape(*shape, *values.shape[1:]))
        for key, values in found.items()
    }
    velocity = look([impulse]).N_first * device.gravity / (2e-6 * impulse)
    data |= {"N_static": ((), static_threshold(device)), "velocity_change": ("C", velocity)}
    document = {
        "device": device_document(device),
        "model": model,
        "sweep": {
            "horizon": f"{horizon!r} us",
            "energy_tolerance": energy_tolerance,
            "threshold_tolerance": tolerance,
        },
    }
    return xr.Dataset(
        {key: (*values, VARIABLES[key]) for key, values in data.items()},
        {key: (key, values, COORDINATES[key]) for key, values in {"C": C, "f0": f0}.items()},
    ).assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title="Thresholds of snap-through under a versed-sine shock",
        summary="Amplitudes where snapping begins and is certain, over damping and frequency",
        gravity=device.gravity,
        **provenance(document),
    )


def summary(found: xr.Dataset) -> str:
    """One line: how many thresholds, how many have islands, and how sure they are."""
    relative = (found.N_error / found.N_first).values
    known = relative[np.isfinite(relative)]
    typical = f"{np.median(known):.2%}" if known.size else "unknown"
    return (
        f"{int(found.N_first.notnull().sum())} of {found.N_first.size} thresholds found, "
        f"{int((found.islands > 0).sum())} with islands, {int((known > 0.01).sum())} with an error "
        f"above 1 %, median {typical}"
    )


def _check(f0, C, tolerance, highest, protocol):
    check_cells(f0=f0, C=C)
    check_protocol(protocol)
    check_number("tolerance", tolerance)
    if not 1e-9 <= tolerance <= 0.01:
        raise ValueError(f"tolerance: {tolerance} is not from 1e-9 to 0.01, of N")
    if highest is not None:
        check_number("highest", highest)
        if not np.isfinite(highest):
            raise ValueError(f"highest: {highest} is not a finite multiple of g")
