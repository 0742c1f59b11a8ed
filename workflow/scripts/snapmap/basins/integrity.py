"""Integrity of a cube's maps: how far each cell is from another label, and what N erodes of it."""

import numpy as np
import xarray as xr
from scipy.ndimage import distance_transform_edt

from ..solver.outcome import ABSENT, FAILED, LATCHED, SNAPPED
from .entropy import basin_entropy, disk_entropy, uncertain_shares, uncertainty_exponent

PLANE = ("f0", "N")
SAFE, TRIPPED, DIVERGED = 1, 2, -1
"""Labels, as Attractors.jl has them: from 1, and -1 for what has no attractor."""
FEWEST = 6
"""Cells of the widest window of a small map; of others it is a fifth of the shorter axis."""
SHARE = {"units": "1"}
VARIABLES = {
    "basins": {
        "long_name": "label of the cell",
        "flag_values": np.array([SAFE, TRIPPED, DIVERGED], np.int8),
        "flag_meanings": "not_tripped tripped failed_or_absent",
    },
    "integrity": {
        "long_name": "distance of the cell to the nearest one of another label",
        "comment": "each axis is as wide as 1, in the scale on which it is even; inf: no other",
        **SHARE,
    },
    "safe_share": {"long_name": "share of the cells of an N whose label is 1", **SHARE},
    "safe_distance": {"long_name": "largest integrity of the cells of an N of label 1", **SHARE},
    "basin_entropy": {"long_name": "mean entropy of the labels in a box", **SHARE},
    "boundary_entropy": {"long_name": "the same over boxes with several labels", **SHARE},
    "disk_entropy": {
        "long_name": "mean entropy of the labels in disks with several labels",
        "comment": "of a smooth boundary 0.4395093, and up to 0.224 / radius more",
        **SHARE,
    },
    "uncertain_share": {"long_name": "share of the windows with several labels", **SHARE},
    "uncertainty_exponent": {"long_name": "1 where the boundary is smooth", **SHARE},
    "uncertainty_exponent_error": {"long_name": "standard error of the exponent", **SHARE},
}


def integrity(cube: xr.Dataset, box: int | None = None) -> xr.Dataset:
    """Measure how far the cells of a cube are from other labels, and how uncertain labels are.

    cube: as `sweep` and `open_cube` return it; f0 and N each even, or its logarithm or inverse
    box: side of the boxes, and width of the disks, of the entropies, cells; by default a tenth of
        the shorter axis
    Variables over `labels` ("snaps": whether a cell snaps; "ends": on which side it was last seen,
    if runs go on beyond a snap) and the cube's further axes; `basins`, the labels, are integers
    that Attractors.jl reads. Raises ValueError, one line, for axes that are not even, and for a box
    that is no part of them.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cheap = {"model": "cosines", "modes": 5, "horizon": 0}
    >>> cube = snapmap.sweep(device, [900, 1000, 1100], [500, 1000], [25], **cheap)
    >>> snapmap.integrity(cube).basins.sel(labels="snaps").values.squeeze().tolist()
    [[1, 2, 2], [1, 2, 2]]
    """
    if missing := [key for key in (*PLANE, "outcome") if key not in (*cube.dims, *cube)]:
        raise ValueError(f"{missing[0]}: is missing in what is given; give a cube over N and f0")
    widths = [_width(cube, key) for key in PLANE]
    shape = [cube.sizes[key] for key in PLANE if cube.sizes[key] > 1]
    box = max(2, min(shape, default=0) // 10) if box is None else box
    if not 2 <= box <= min(shape, default=0):
        raise ValueError(
            f"box: {box} is not from 2 to the {min(shape, default=0)} cells of an axis"
        )
    sizes = np.arange(2, max(FEWEST, min(shape, default=0) // 5) + 1)
    labels = labels_of(cube)
    told = xr.apply_ufunc(
        lambda plane: _measured(plane, widths, box, sizes),
        labels,
        input_core_dims=[PLANE],
        output_core_dims=[PLANE, ["N"], ["N"], [], [], [], ["window"], [], []],
        vectorize=True,
    )
    names = [key for key in VARIABLES if key != "basins"]
    found = xr.Dataset({"basins": labels} | dict(zip(names, told, strict=True)))
    found = found.assign_coords(cube.coords).assign_coords(
        window=("window", sizes, {"long_name": "side of the window, cells", **SHARE})
    )
    for key, attributes in VARIABLES.items():
        found[key].attrs = attributes
    told = {"title": "Integrity of maps", "box": box}
    told["summary"] = "Distance of each cell to another label, and how uncertain labels are"
    return found.assign_attrs(cube.attrs | told)


def labels_of(cube: xr.Dataset) -> xr.DataArray:
    """Integers for the labels of a cube's cells, over their kinds and its axes, PLANE last."""
    outcome = cube.get("outcome_code", cube.outcome)
    tripped = {"snaps": cube.t_snap.notnull()}
    if "well" in cube:  # else runs end at their snap
        # ASSUME: a cell that is open belongs to the side on which it was last seen.
        open_ends = (cube.well == 2) | ((cube.well == 0) & (outcome == SNAPPED))
        tripped["ends"] = (outcome == LATCHED) | open_ends
    names = xr.Variable("labels", list(tripped), {"long_name": "what the labels tell apart"})
    found = xr.concat(list(tripped.values()), names)
    labels = xr.where(outcome.isin([FAILED, ABSENT]), DIVERGED, xr.where(found, TRIPPED, SAFE))
    return labels.transpose("labels", ..., *PLANE).astype(np.int8)


def _width(cube, key):
    """Of a cell on an axis as wide as 1."""
    values = cube[key].values
    if values.size < 3:
        return 1.0 / max(1, values.size - 1)
    scales = (values, np.log(values), 1 / values) if values[0] > 0 else (values,)
    for apart in map(np.diff, scales):
        if np.ptp(apart) < 0.01 * abs(apart.mean()):
            return 1.0 / (values.size - 1)
    raise ValueError(f"{key}: no values evenly apart, nor are their logarithms or inverses")


def _measured(plane, widths, box, sizes):
    """All that is told of one map, in the order of VARIABLES."""
    distance = distances(plane, widths)
    safe = plane == SAFE
    largest = np.where(safe, distance, 0.0).max(axis=0)
    flat = np.squeeze(plane)
    uncertain = uncertain_shares(flat, sizes)
    entropies = *basin_entropy(flat, box), disk_entropy(flat, box // 2)
    exponent = uncertainty_exponent(sizes, uncertain)
    return distance, safe.mean(axis=0), largest, *entropies, uncertain, *exponent


def distances(labels: np.ndarray, widths: list[float]) -> np.ndarray:
    """Distance of each cell to the nearest of another label; inf where there is none.

    labels: integers; widths: of a cell on each axis
    """
    names = np.unique(labels)
    if names.size == 1:
        return np.full(labels.shape, np.inf)
    far = [distance_transform_edt(labels == name, sampling=widths) for name in names]
    return np.sum(far, axis=0)  # each is 0 outside its label
