"""The cube as an xarray dataset: what it looks like, built here."""

from collections.abc import Mapping, Sequence

import dask.array
import numpy as np
import xarray as xr

from .cells import check_cells
from .config import device_document
from .device import Device
from .grid import AXES, follow_grid
from .ladder import choose_model
from .outcome import OUTCOMES, count, shares
from .protocol import Protocol, check_protocol
from .provenance import provenance

COORDINATES = {
    "C": {"long_name": "damping coefficient of the mass", "units": "uN us um-1"},
    "f0": {"long_name": "frequency of the pulse", "units": "Hz"},
    "N": {"long_name": "amplitude of the pulse in multiples of g", "units": "1"},
}
VARIABLES = {
    "outcome": {
        "long_name": "outcome of the cell",
        "flag_values": np.arange(len(OUTCOMES), dtype=np.int8),
        "flag_meanings": " ".join(OUTCOMES),
    },
    "t_snap": {
        "long_name": "first arrival of the midpoint at the second equilibrium",
        "units": "us",
        "comment": "counted from the start of the pulse; NaN: not within the horizon",
    },
    "t_settled": {
        "long_name": "time at which the beam was proven to stay in its well for ever",
        "units": "us",
        "comment": "counted from the start of the pulse; NaN: not proven within the horizon",
    },
    "energy_error": {
        "long_name": "residual of the energy ledger over the gross work of the pulse",
        "units": "1",
    },
    "halvings": {
        "long_name": "how often the time step was halved until the energy ledger closed",
        "units": "1",
    },
    "level": {
        "long_name": "level of the model that decided the cell",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "base top",
    },
    "agreed": {
        "long_name": "whether no two levels that decided the cell disagree on whether it snaps",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "disputed agreed",
    },
    "reproduced": {
        "long_name": "whether a run with another time step had the same outcome",
        "flag_values": np.arange(2, dtype=np.int8),
        "flag_meanings": "not_reproduced reproduced",
    },
}


def sweep(
    device: Device,
    N: Sequence[float],
    f0: Sequence[float],
    C: Sequence[float],
    model: str = "handout",
    horizon: float = 1500.0,
    until: str = "settled",
    repeat: bool | None = None,
    energy_tolerance: float = 1e-3,
    threads: int = 1,
    **options,
) -> xr.Dataset:
    """Simulate every cell of a grid and return it as in cube.nc.

    N: multiples of g; f0: Hz, above 0; C: uN us/um, from 0
    horizon (us), until, repeat, energy_tolerance: as in `Protocol`; only settled cells are
        repeated unless told
    model, options: as in the config's model section
    Raises ValueError, one line, for a value that cannot be.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cube = snapmap.sweep(device, [900, 1100], [1500], [25], model="cosines", until="snap")
    >>> cube.t_snap.notnull().squeeze().values.tolist()
    [False, True]
    """
    check_cells(N=N, f0=f0, C=C)
    repeat = until == "settled" if repeat is None else repeat
    protocol = Protocol(horizon, until, repeat, energy_tolerance)
    check_protocol(protocol)
    built = choose_model(device, model, **options)
    axes = [np.atleast_1d(np.asarray(values, float)) for values in (C, f0, N)]
    variables = follow_grid(built, axes, protocol, threads)
    document = {
        "device": device_document(device),
        "model": {"name": model, **options},
        "sweep": protocol._asdict() | {"horizon": f"{horizon!r} us"},
    }
    return with_summary(dress(axes, variables, document))


def dress(axes: Sequence, variables: Mapping, document: Mapping) -> xr.Dataset:
    """Give axes and variables, (C, f0, N), their CF attributes, and the whole its provenance."""
    coordinates = zip(AXES, axes, strict=True)
    cube = xr.Dataset(
        {key: (AXES, variables[key], VARIABLES[key]) for key in variables},
        {key: (key, values, COORDINATES[key]) for key, values in coordinates},
    )
    return cube.assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title="Snap-through of a bistable beam under a versed-sine shock",
        summary="Outcome of each cell of a grid over damping, frequency and amplitude of the shock",
        **provenance(document),
    )


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add the number of cells of each outcome and the shares of `outcome.shares` as attributes."""
    found = [count(block) for block in _blocks(cube.outcome)]
    counts = {name: sum(block.get(name, 0) for block in found) for name in OUTCOMES}
    counts = {name: number for name, number in counts.items() if number}
    reproduced = None
    if "reproduced" in cube:
        reproduced = sum(int((block == 1).sum()) for block in _blocks(cube.reproduced))
    named = {f"cells_{name}": number for name, number in counts.items()}
    return cube.assign_attrs(named | shares(counts, reproduced))


def _blocks(variable):
    """The values of a variable, a block at a time, as a lazy cube may be larger than memory."""
    for block in dask.array.asarray(variable.data).blocks.ravel():
        yield block.compute(scheduler="synchronous")


def summary(cube: xr.Dataset) -> str:
    """One line of what `with_summary` added."""
    found = {key: cube.attrs[key] for key in cube.attrs if key.startswith(("cells_", "share_"))}
    return ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in found.items())
