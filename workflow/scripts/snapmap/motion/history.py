"""One cell in full: motion, contact force and every energy over time."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..beam.modal import contact_stiffness
from ..beam.stress import stress_of
from ..device import Device
from ..io.provenance import device_sections, provenance
from ..numerics.linalg import dot, multiply
from ..pulse import blow_at
from ..solver.adaptive import choose_model
from ..solver.cells import to_cells
from ..solver.repeat import REPEATED_STEP, t_snap_error, work_error
from ..solver.settings import MOVE
from ..study import Study, study_of
from .travel import warn_of_travel

SAMPLES = 4000
"""A history keeps this many instants, up to twice as many, or all that there are."""
SAMPLES_OF_EXTREMES = 50_000
"""Likewise what is looked at for the largest values: all of most motions."""

VARIABLES = {
    "w_mid": ("deflection of the beam's midpoint", "um"),
    "z_mass": ("position of the mass", "um"),
    "contact_force": ("force between mass and beam", "uN"),
    "acceleration": ("acceleration of the frame", "um us-2"),
    "axial_force": ("compressive axial force in the beam", "uN"),
    "stress": ("largest tensile stress in the beam", "MPa"),
    "kinetic_energy": ("kinetic energy of mass and beam", "pJ"),
    "spring_energy": ("energy of the mass's spring", "pJ"),
    "bending_energy": ("bending energy of the beam", "pJ"),
    "axial_energy": ("axial energy of the beam", "pJ"),
    "contact_energy": ("energy of the contact", "pJ"),
    "dissipated_energy": ("energy taken by the damping of mass and beam", "pJ"),
    "pulse_work": ("work of the pulse on mass and beam", "pJ"),
    "midpoint_force": ("force of the pulse on the beam's midpoint, downward", "uN"),
}


def simulate(
    device: Device,
    N: float,
    f0: float | None,
    C: float,
    model: str | Mapping = "auto",
    **options,
) -> xr.Dataset:
    """Follow one cell to the horizon, beyond its snap, and return its history over time.

    N: multiples of g; f0: Hz, or None for a recorded shock's own; C: uN us/um
    model: name, or as a mapping the whole of the config's model section; of `auto` the finest level
    options: as in `study.study_of`: horizon (us followed after the pulse), until and
        energy_tolerance, of a sweep whose step for this cell is taken; pulse and direction, of one
        shape in one direction; and options of the model
    The attributes work_error and t_snap_error say by how much the pulse's work and the time of snap
    differ with another step, as in a cube; stress_max and stress_max_to_snap are the largest of the
    stress, MPa, over the instants that are kept, and over those up to the snap; of a train, blow
    tells at which it snaps.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> run = snapmap.simulate(device, 1100, 1500, 25, model="cosines", horizon=0)
    >>> bool(run.w_mid.min() < device.beam.second_equilibrium)
    True
    """
    study, _ = study_of(device, model, options, ("horizon", "energy_tolerance", "until"))
    f0 = study.shocks.own_frequency() if f0 is None else f0
    return history_of(study, N, f0, C)


def history_of(study: Study, N: float, f0: float, C: float) -> xr.Dataset:
    """Follow one cell of a study of one device and pulse, as `simulate` does."""
    if study.shocks.axes:
        raise ValueError("pulse: several; a history is of one shape in one direction")
    device, settings = study.device, study.settings._replace(repeat=False)
    built, cells, t_snap = _cell(study, N, f0, C)
    blow = blow_at(settings.pulses, cells.pulse, t_snap * cells.f0).item()
    time, dt, values = _record(built, cells, settings, SAMPLES)
    document = {
        **device_sections(device),
        **study.shocks.section(),
        "model": dict(study.model),
        "histories": [{"N": N, "f0": f"{f0!r} Hz", "C": f"{C!r} uN*us/um"}],
    }
    return _dress(time, values, document).assign_attrs(
        N=N,
        f0=f0,
        C=C,
        second_equilibrium=built.barrier.second,
        barrier=built.barrier.energy,
        gravity=device.gravity,
        time_step=dt,
        **_stresses(values, built.barrier.second),
        **_stops(device, built.barrier.first),
        **({"blow": blow} if settings.pulses[0].blows.size else {}),
        **_differences(built, cells, settings),
    )


def _stops(device, first):
    """Where the mass meets its stops, um, of those that it has."""
    rest = first + device.gap
    places = {"stop_toward": rest - device.stop_toward, "stop_away": rest + device.stop_away}
    return {key: place for key, place in places.items() if math.isfinite(place)}


def _stresses(values, second):
    """The largest stress, MPa, over the run and up to its snap, by their names."""
    snapped = np.flatnonzero(values["w_mid"] <= second)[:1]
    before = values["stress"][: snapped[0] + 1] if snapped.size else values["stress"]
    found = {"stress_max": values["stress"], "stress_max_to_snap": before}
    return {key: part.max().item() for key, part in found.items()}


class Extremes(NamedTuple):
    """What a device meets under one shock, to the horizon.

    toward_max, away_max: of the mass from rest, toward the beam and away from it, um
    contact_force_max: between mass and beam, uN
    stress_max, stress_max_to_snap: tensile, in the beam, MPa
    """

    toward_max: float
    away_max: float
    contact_force_max: float
    stress_max: float
    stress_max_to_snap: float


def extremes_of(study: Study, N: float, f0: float, C: float, step: float = 1.0) -> Extremes:
    """Follow one cell of a study of one device and pulse for what is largest in its motion.

    step: over the one that the motion needs
    """
    built, cells, _ = _cell(study, N, f0, C)
    _, _, values = _record(built.with_step(step), cells, study.settings, SAMPLES_OF_EXTREMES)
    y = values["z_mass"] - (built.barrier.first + study.device.gap)
    ways = np.maximum(0.0, [-y.min(), y.max()])  # NaN of a run that failed
    pressed = values["contact_force"].max().item()
    return Extremes(*ways.tolist(), pressed, **_stresses(values, built.barrier.second))


def _cell(study, N, f0, C):
    """The model at the step that a sweep takes for a cell, the cell, and when it then snaps, us."""
    cells = to_cells(study.device, [0], [N], [f0], [C], study.settings.horizon)
    built = choose_model(study.device, study.model).levels[-1]
    seen = built.follow(cells, study.settings._replace(repeat=False))
    return built.with_step(0.5 ** seen.halvings.item()), cells, seen.t_snap


def _record(built, cells, settings, samples):
    """Instants, us, the time step, and the values of a cell at so many of them, or more."""
    dt = built.steps.of(cells, settings.pulses, MOVE).item()
    amplitude, per_us, damping, t_end = (column.item() for column in cells[2:])
    steps, stride = _sampling(t_end, dt, samples)
    shock = settings.pulses[0]
    motion, form = built.loop().record(built, shock, amplitude, per_us, damping, dt, steps, stride)
    warn_of_travel(built.device, motion.y.min(), motion.y.max())
    stress = stress_of(built.device.beam, built.basis, form.shapes)
    shaken = amplitude * shock.at(per_us * motion.time)
    values = _observe(built.device, built.barrier.first, form, stress, motion) | {
        **_load(built.device, shaken),
        "dissipated_energy": motion.lost,
        "pulse_work": motion.work,
    }
    return motion.time, dt, values


def _load(device, shaken):
    """What the pulse is, by its name, from N gravity over time."""
    if device.force:
        return {"midpoint_force": shaken / device.gravity * device.force}
    return {"acceleration": shaken}


def _differences(model, cells, settings):
    """By how much the pulse's work and the time of snap, us, differ with another step."""
    settings = settings._replace(until="moved")
    # No snap ends a run of the model `reference` before its pulse is over.
    onward = replace(model, barrier=model.barrier._replace(second=-np.inf))
    models = {work_error: onward, t_snap_error: model}
    differences = {}
    for compare, one in models.items():
        again = one.with_step(REPEATED_STEP)
        runs = (each.follow_once(cells, settings) for each in (one, again))
        differences[compare.__name__] = compare(*runs).item()
    return differences


def _sampling(t_end, dt, samples):
    """Steps to t_end, and the largest power of two between samples that keeps so many or more."""
    steps = int(np.ceil(t_end / dt))
    stride = 2 ** max(0, math.floor(math.log2(max(1, steps / samples))))
    return steps, stride


def _observe(device, first, form, stress, motion):
    """Deflections, forces and energies from the coordinates; first: w(L/2) at rest, um."""
    velocity = motion.u_velocity
    stiffness = contact_stiffness(device, form.residual)
    overlap = dot(motion.u, form.midpoint) - motion.y - device.gap
    contact = stiffness * np.maximum(0.0, overlap)
    axial_force = -device.beam.axial_stiffness * motion.stretch
    rest = math.nan if device.is_alone else first + device.gap
    kinetic = dot(velocity, multiply(velocity, form.inertia)) / 2
    return {
        "w_mid": first + dot(motion.u, form.midpoint) - form.residual * contact,
        # Half way through the step in which it bounces the mass is beyond a stop.
        "z_mass": rest + np.clip(motion.y, -device.stop_toward, device.stop_away),
        "contact_force": contact,
        "axial_force": axial_force,
        "stress": stress.largest(motion.u, contact, axial_force),
        "kinetic_energy": kinetic + device.mass * motion.y_velocity**2 / 2,
        "spring_energy": device.spring * motion.y**2 / 2,
        "bending_energy": dot(motion.u, multiply(motion.u, form.bending)) / 2,
        "axial_energy": axial_force**2 / (4 * device.beam.axial_stiffness),
        "contact_energy": contact**2 / (2 * stiffness),
    }


def _dress(time, values, document):
    data = {
        key: ("time", values[key], {"long_name": name, "units": unit})
        for key, (name, unit) in VARIABLES.items()
        if key in values
    }
    axis = ("time", time, {"long_name": "time after the start of the pulse", "units": "us"})
    return xr.Dataset(data, {"time": axis}).assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title="Time history of one cell",
        summary="Motion, forces and energies of beam and mass under one shock",
        **provenance(document),
    )
