"""The results as xarray datasets: what a cube looks like, built, collected and written here."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import dask
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
from .survey import survey

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
THRESHOLDS = {
    "N_first": {"long_name": "lowest amplitude that snaps, in multiples of g", "units": "1"},
    "N_always": {
        "long_name": "lowest amplitude above which all snap, in multiples of g",
        "units": "1",
        "comment": "looked for up to twice N_first",
    },
    "N_error": {
        "long_name": "uncertainty of N_first from space, time and refinement",
        "units": "1",
    },
    "islands": {"long_name": "stretches of N below N_always that snap", "units": "1"},
}
ENCODING = {"zlib": True, "complevel": 4, "shuffle": True}


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
    """
    check_cells(N=N, f0=f0, C=C)
    repeat = until == "settled" if repeat is None else repeat
    protocol = Protocol(horizon, until, repeat, energy_tolerance)
    check_protocol(protocol)
    built = choose_model(device, model, **options)
    axes = [np.atleast_1d(np.asarray(values, float)) for values in (C, f0, N)]
    variables = follow_grid(device, built, axes, protocol, threads)
    document = {
        "device": device_document(device),
        "model": {"name": model, **options},
        "sweep": protocol._asdict() | {"horizon": f"{horizon!r} us"},
    }
    return with_summary(dress(axes, variables, document))


def threshold(
    device: Device,
    f0: Sequence[float],
    C: Sequence[float],
    horizon: float = 1500.0,
    model: str = "auto",
    tolerance: float = 1e-4,
    threads: int = 1,
    **options,
) -> xr.Dataset:
    """Find where snapping begins over C (uN us/um) and f0 (Hz), with error bars.

    horizon: us followed after the pulse; tolerance: of the refinement in N, relative
    model, options: as in the config's model section; `auto` takes its own default tolerance
    The variables are those of `survey.Survey`, (C, f0).
    """
    check_cells(f0=f0, C=C)
    axes = [np.atleast_1d(np.asarray(values, float)) for values in (C, f0)]
    rows = [values.ravel() for values in np.meshgrid(*axes, indexing="ij")]
    chosen = choose_model(device, model, **options)
    found = survey(device, chosen, rows[1], rows[0], Protocol(horizon), tolerance, threads)
    shape = [values.size for values in axes]
    variables = {
        key: (AXES[:2], values.reshape(shape), THRESHOLDS[key])
        for key, values in found._asdict().items()
    }
    coordinates = {
        key: (key, values, COORDINATES[key]) for key, values in zip(AXES, axes, strict=False)
    }
    document = {
        "device": device_document(device),
        "model": {"name": model, **options},
        "sweep": {"horizon": f"{horizon!r} us"},
    }
    return xr.Dataset(variables, coordinates).assign_attrs(
        Conventions="CF-1.11",
        title="Thresholds of snap-through under a versed-sine shock",
        **provenance(document),
    )


def collect_slabs(
    paths: Sequence[str | Path], names: Sequence[Sequence[str]], document: Mapping
) -> xr.Dataset:
    """Join slabs lazily into one cube; raises ValueError for a file that is not its slab.

    paths: one after the other as in names
    names: a row for each C, in each the slabs' names in order of f0
    document: the config, kept in the attributes
    """
    files = iter(paths)
    rows = [xr.concat([_open_slab(next(files), name) for name in row], dim="f0") for row in names]
    joined = xr.concat(rows, dim="C")
    variables = {key: joined[key].data for key in VARIABLES if key in joined}
    return with_summary(dress([joined[key].values for key in AXES], variables, document))


def _open_slab(path, name):
    slab = xr.open_dataset(path, engine="netcdf4", chunks={})
    if slab.attrs.get("slab") != name:
        raise ValueError(f"{path}: holds slab {slab.attrs.get('slab')}, not {name}; remove it")
    return slab


def dress(axes: Sequence, variables: Mapping, document: Mapping) -> xr.Dataset:
    """Give axes and variables, (C, f0, N), their CF attributes, and the whole its provenance."""
    coordinates = zip(AXES, axes, strict=True)
    cube = xr.Dataset(
        {key: (AXES, variables[key], VARIABLES[key]) for key in variables},
        {key: (key, values, COORDINATES[key]) for key, values in coordinates},
    )
    return cube.assign_attrs(
        Conventions="CF-1.11",
        title="Snap-through of a bistable beam under a versed-sine shock",
        **provenance(document),
    )


def with_summary(cube: xr.Dataset) -> xr.Dataset:
    """Add the number of cells of each outcome and the shares of `outcome.shares` as attributes."""
    with dask.config.set(scheduler="synchronous"):
        outcome = cube.outcome.values
        reproduced = cube.reproduced.values if "reproduced" in cube else None
    counts = {f"cells_{name}": number for name, number in count(outcome).items()}
    return cube.assign_attrs(counts | shares(outcome, reproduced))


def summary(cube: xr.Dataset) -> str:
    """One line of what `with_summary` added."""
    found = {key: cube.attrs[key] for key in cube.attrs if key.startswith(("cells_", "share_"))}
    return ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in found.items())


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset compressed, under a temporary name until it is whole."""
    temporary = f"{path}.part"
    encoding = {key: ENCODING for key in dataset.data_vars}
    # netCDF4 is not safe in threads, so dask must work in this one.
    with dask.config.set(scheduler="synchronous"):
        dataset.to_netcdf(temporary, engine="netcdf4", encoding=encoding)
    os.replace(temporary, path)
