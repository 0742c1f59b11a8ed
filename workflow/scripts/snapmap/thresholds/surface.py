"""The threshold surface over damping and frequency as an xarray dataset."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..axes import PULSE_AXES
from ..device import Device
from ..io.counting import counting
from ..io.netcdf import recall
from ..io.provenance import recipe
from ..io.variables import dress, flags
from ..pulse import blow_at
from ..solver.adaptive import choose_survey
from ..solver.cells import rows_of, to_rows
from ..solver.settings import THRESHOLD_TOLERANCE
from ..study import THRESHOLD_SETTINGS, Study, frequencies, study_of
from .cost import tell_cost
from .islands import (
    ABOVE,
    FINEST_STEP,
    NARROW,
    NOT_FOLLOWED,
    NOTHING_SNAPS,
    STATUS,
    survey,
)
from .reuse import joined
from .settling import lowest_latched
from .transitions import FINE_STEP

IMPULSE, IMPULSE_OF_BEAM = 100.0, 10.0
"""A pulse of so many times the device's own frequency, and the beam's, is as good as a jump in
velocity."""

SLOWNESS = 0.02
"""Frequency, over the device's own, of a pulse that stands for a long one where it jumps."""
NO_AREA = 1e-3
"""A pulse of less area leaves no change of velocity by which it could trip."""
ROWS = 4096
"""Rows looked at together: each takes some 70 kB."""

COMMENT = (
    f"in multiples of g; narrower stretches may lie below: than {NARROW:.2%} of N near a clean "
    f"threshold of a fast pulse, {FINEST_STEP:.1%} near a ragged one, {FINE_STEP:.1%} elsewhere"
)


def threshold(
    device: Device | Mapping[str, Device],
    f0: Sequence[float] | None,
    C: Sequence[float],
    model: str | Mapping = "auto",
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
    earlier: xr.Dataset | None = None,
    **options,
) -> xr.Dataset:
    """Find where snapping begins over C (uN us/um) and f0 (Hz), with error bars.

    device: one, or several by name, which then are an axis
    f0: None for a recorded shock's own
    model: name, or as a mapping the whole of the config's model section, which may give `auto` a
        tolerance of its own
    tolerance: of the refinement in N, relative
    highest: up to which N islands are looked for; twice the threshold if not given
    earlier: thresholds of the same study on other axes, from which rows are taken that the same
        code found
    options: as in `study.study_of`: horizon (us followed after the pulse), energy_tolerance and
        threads, as in `Settings`; pulse; direction; skip: whether a device without a second stable
        shape has no threshold, and is not refused; options of the model; and values of the device
        by their names, in internal units, as axes in front of C and f0
    The variables are those of `islands.Thresholds`, (..., C, f0), with N_latched; the limits for
    slow and short pulses, N_static, over the axes of device and pulse, and velocity_change, over
    these and C; and the `area` of each pulse: its velocity change is area N g / f0. Of records in
    known units `scale_first` is the factor of the record at which it snaps. `status` is a
    number, in words `numpy.array(found.status.flag_meanings.split())[found.status]`.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> found = snapmap.threshold(device, [1500], [25], model="cosines", thickness=[1.9, 2.0])
    >>> found.N_first.squeeze().round().values.tolist()
    [893.0, 990.0]
    """
    study, varied = study_of(device, model, options)
    axes = {**varied, "C": C, "f0": frequencies(f0, study.shocks)}
    with counting("threshold"):
        return thresholds_of(study, axes, tolerance, highest, earlier)


def thresholds_of(
    study: Study,
    axes: Mapping[str, Sequence[float]],
    tolerance: float = THRESHOLD_TOLERANCE,
    highest: float | None = None,
    earlier: xr.Dataset | None = None,
) -> xr.Dataset:
    """Find the thresholds of a study, as `threshold` returns them.

    axes: values of the device, C and f0, by name; tolerance, highest, earlier: as there
    """
    settings = study.settings
    grid = study.set_out(axes)
    document = study.document(THRESHOLD_SETTINGS)
    document["sweep"]["threshold_tolerance"] = tolerance
    made_by = recipe(document, grid.pulses, highest)
    models, rows = choose_survey(grid.device, study.model), rows_of(grid)
    found, known = recall(earlier, grid, made_by)
    new = np.flatnonzero(~known & (rows.device >= 0))
    tell_cost(models, rows.some(new), settings)
    found = _look(models, rows, settings, tolerance, highest, new, found)
    peak = np.array([pulse.peak for pulse in rows.pulses])
    if np.isfinite(peak).any():
        found["scale_first"] = (
            found["N_first"] * grid.device.gravity[rows.device] / peak[rows.pulse]
        )
    dims = *grid.axes, "island"
    data = {
        key: (
            dims[: len(grid.shape) + values.ndim - 1],
            values.reshape(*grid.shape, *values.shape[1:]),
        )
        for key, values in found.items()
    }
    data |= _limits(grid, models, settings, tolerance, highest)
    data["status"] = *data["status"], flags(STATUS)
    data["N_first"] = *data["N_first"], {"comment": COMMENT}
    of_product = {"gravity": float(grid.device.gravity[0]), "recipe": made_by}
    return dress("threshold", xr.Dataset(data, grid.axes), document, **of_product)


def _look(models, rows, settings, tolerance, highest, new, known):
    """Thresholds of all rows by name: of the new ones, given by their indices, and those known."""
    whole = known
    blocks = np.split(new, range(ROWS, new.size, ROWS)) if new.size or not known else []
    for block in blocks:
        found = _look_at(models, rows.some(block), settings, tolerance, highest)
        whole = {
            key: joined(rows.f0.size, block, found.get(key), whole.get(key))
            for key in found | whole
        }
    if any(pulse.blows.size for pulse in rows.pulses):
        whole["blow"] = blow_at(rows.pulses, rows.pulse, whole["t_snap"] * rows.f0 * 1e-6)
    most = whole["islands"].max(initial=0)
    return whole | {key: whole[key][:, :most] for key in ("island_from", "island_to")}


def _look_at(models, rows, settings, tolerance, highest):
    found = survey(models, rows, settings, tolerance, highest)._asdict()
    first = found["N_first"]
    top = np.where(np.isnan(first), np.nan, ABOVE * first if highest is None else highest)
    low = np.where(first <= top, first, np.nan)
    return found | {"N_latched": lowest_latched(models.decides, rows, low, top, settings)}


def _limits(grid, models, settings, tolerance, highest):
    """Thresholds of slow and of short pulses, of trains their strongest blow; and their area."""
    device, C = grid.device, grid.axes["C"]
    own, of_beam = device.own_frequency, device.beam.bending_frequency
    fast, slow = np.maximum(IMPULSE * own, IMPULSE_OF_BEAM * of_beam), SLOWNESS * own
    alone = tuple(pulse.alone for pulse in grid.pulses)

    def look(omega, which, C):
        """N_first, (devices, pulses, C), of pulses of one frequency for each device, rad/us."""
        shape = len(device), len(which), C.size
        numbers, pulse, damping = (place.ravel() for place in np.indices(shape))
        f0 = omega[numbers] / (2 * np.pi) * 1e6
        rows = to_rows(numbers, f0, C[damping], np.array(which)[pulse], alone)
        return survey(models, rows, settings, tolerance, highest).N_first.reshape(shape)

    area = np.array([pulse.area for pulse in alone])
    pushes = [p for p, size in enumerate(abs(area)) if size > NO_AREA]
    change = np.full((len(device), area.size, C.size), np.nan)
    lasts = 2 * np.pi / fast
    if pushes:
        change[:, pushes] = look(fast, pushes, C) * (device.gravity * lasts)[:, None, None]
    change *= abs(area)[:, np.newaxis]
    impact = np.array([pulse.impact for pulse in grid.pulses])
    with np.errstate(divide="ignore"):
        highest_of = np.array([one.highest for one in grid.pulses])
        static = models.static[:, np.newaxis] / np.where(highest_of > 0, highest_of, np.nan)
    jumps = [p for p, one in enumerate(grid.pulses) if any(one.ends)]
    if jumps:
        static[:, jumps] = look(slow, jumps, C[:1])[..., 0]

    of_pulse = {key: grid.axes[key] for key in PULSE_AXES if key in grid.axes}
    sizes = [values.size for values in of_pulse.values()]
    of_device = tuple(grid.axes)[: grid.device_of.ndim]
    there = grid.device_of >= 0

    def spread(values):
        values = values.reshape(len(device), *sizes, *values.shape[2:])
        known = np.expand_dims(there, tuple(range(there.ndim, there.ndim + values.ndim - 1)))
        return np.where(known, values[np.where(there, grid.device_of, 0)], np.nan)

    return {
        "N_static": ((*of_device, *of_pulse), spread(static)),
        "velocity_change": ((*of_device, *of_pulse, "C"), spread(change)),
        "area": (tuple(of_pulse), abs(impact).reshape(sizes)),
    }


def summary(found: xr.Dataset) -> str:
    """One line: thresholds from where to where, ragged ones, how sure they are; the weaker side."""
    N = found.N_first.values[np.isfinite(found.N_first.values)]
    ends = f"from N = {N.min():.4g} to {N.max():.4g}, " if N.size else ""
    relative = (found.N_error / found.N_first).values
    known = relative[np.isfinite(relative)]
    typical = f"{np.median(known):.2%}" if known.size else "unknown"
    ragged = int(found.ragged.where(found.N_first.notnull(), 0).sum())
    line = (
        f"{N.size} of {found.N_first.size} thresholds found, {ends}"
        f"{ragged} of them ragged, {int((known > 0.01).sum())} with an error above 1 %, "
        f"median {typical}"
    )
    for number in (NOTHING_SNAPS, NOT_FOLLOWED):
        count = int((found.status == number).sum())
        line += f"; {STATUS[number].replace('_', ' ')} in {count}" if count else ""
    if found.sizes.get("direction", 1) < 2:
        return line
    # Where nothing snaps, the other side is the weaker one.
    weaker = (
        found.N_first.fillna(np.inf)
        .idxmin("direction")
        .where(found.N_first.notnull().any("direction"))
    )
    sides = [f"{side} in {int((weaker == side).sum())} rows" for side in found.direction.values]
    return f"{line}; weaker along {', '.join(sides)}"
