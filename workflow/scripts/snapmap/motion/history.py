"""One cell in full: motion, contact force and every energy over time."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from ..beam.modal import contact_stiffness
from ..device import Device
from ..io.provenance import device_sections, provenance
from ..numerics.linalg import dot, multiply
from ..pulse import blow_at
from ..solver.adaptive import choose_model
from ..solver.cells import check_cells, to_cells
from ..solver.repeat import REPEATED_STEP, t_snap_error, work_error
from ..solver.settings import MOVE
from ..study import Study, study_of

SAMPLES = 4000
"""A history keeps this many instants, up to twice as many, or all that there are."""

VARIABLES = {
    "w_mid": ("deflection of the beam's midpoint", "um"),
    "z_mass": ("position of the mass", "um"),
    "contact_force": ("force between mass and beam", "uN"),
    "acceleration": ("acceleration of the frame", "um us-2"),
    "axial_force": ("compressive axial force in the beam", "uN"),
    "kinetic_energy": ("kinetic energy of mass and beam", "pJ"),
    "spring_energy": ("energy of the mass's spring", "pJ"),
    "bending_energy": ("bending energy of the beam", "pJ"),
    "axial_energy": ("axial energy of the beam", "pJ"),
    "contact_energy": ("energy of the contact", "pJ"),
    "dissipated_energy": ("energy taken by the damping of mass and beam", "pJ"),
    "pulse_work": ("work of the pulse on mass and beam", "pJ"),
}


def simulate(
    device: Device,
    N: float,
    f0: float | None,
    C: float,
    model: str | Mapping = "handout",
    **options,
) -> xr.Dataset:
    """Follow one cell to the horizon, beyond its snap, and return its history over time.

    N: multiples of g; f0: Hz, or None for a recorded shock's own; C: uN us/um
    model: name, or as a mapping the whole of the config's model section
    options: as in `study.study_of`: horizon (us followed after the pulse), until and
        energy_tolerance, of a sweep whose step for this cell is taken; pulse and direction, of one
        shape in one direction; and options of the model
    The attributes work_error and t_snap_error say by how much the pulse's work and the time of snap
    differ with another step, as in a cube; of a train, blow tells at which it snaps.

    >>> device = snapmap.load_device("config/config.yaml")
    >>> run = snapmap.simulate(device, 1100, 1500, 25, model="cosines", horizon=0)
    >>> bool(run.w_mid.min() < device.beam.second_equilibrium)
    True
    """
    study, varied = study_of(device, model, options, ("horizon", "energy_tolerance", "until"))
    if varied:
        raise ValueError(f"{next(iter(varied))}: is no option; vary the device")
    f0 = study.shocks.own_frequency() if f0 is None else f0
    return history_of(study, N, f0, C)


def history_of(study: Study, N: float, f0: float, C: float) -> xr.Dataset:
    """Follow one cell of a study of one device and pulse, as `simulate` does."""
    check_cells(N=[N], f0=[f0], C=[C])
    if N < 0:
        raise ValueError(f"N: {N:g} is below 0; direction -z pushes the other way")
    if study.shocks.axes:
        raise ValueError("pulse: several; a history is of one shape in one direction")
    device, settings = study.device, study.settings._replace(repeat=False)
    built = choose_model(device, study.model).levels[-1]
    cells = to_cells(device, [0], [N], [f0], [C], settings.horizon)
    seen = built.follow(cells, settings)
    built = built.with_step(0.5 ** seen.halvings.item())
    dt = built.steps.of(cells, settings.pulses, MOVE).item()
    amplitude, per_us, damping, t_end = (column.item() for column in cells[2:])
    steps, stride = _sampling(t_end, dt)
    shock = settings.pulses[0]
    blow = {"blow": blow_at([shock], cells.pulse, seen.t_snap * per_us).item()}
    motion, form = built.loop().record(built, shock, amplitude, per_us, damping, dt, steps, stride)
    values = _observe(device, built.barrier.first, form, motion) | {
        "acceleration": amplitude * shock.at(per_us * motion.time),
        "dissipated_energy": motion.lost,
        "pulse_work": motion.work,
    }
    document = {
        **device_sections(device),
        **study.shocks.section(),
        "model": dict(study.model),
        "histories": [{"N": N, "f0": f"{f0!r} Hz", "C": f"{C!r} uN*us/um"}],
    }
    return _dress(motion.time, values, document).assign_attrs(
        N=N,
        f0=f0,
        C=C,
        second_equilibrium=built.barrier.second,
        barrier=built.barrier.energy,
        gravity=device.gravity,
        time_step=dt,
        **(blow if shock.blows.size else {}),
        **_differences(built, cells, settings),
    )


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


def _sampling(t_end, dt):
    """Steps to t_end, and the largest power of two between samples that keeps SAMPLES or more."""
    steps = int(np.ceil(t_end / dt))
    stride = 2 ** max(0, math.floor(math.log2(max(1, steps / SAMPLES))))
    return steps, stride


def _observe(device, first, form, motion):
    """Deflections, forces and energies from the coordinates; first: w(L/2) at rest, um."""
    velocity = motion.u_velocity
    stiffness = contact_stiffness(device, form.residual)
    overlap = dot(motion.u, form.midpoint) - motion.y - device.gap
    contact = stiffness * np.maximum(0.0, overlap)
    axial_force = -device.beam.axial_stiffness * motion.stretch
    kinetic = dot(velocity, multiply(velocity, form.inertia)) / 2
    return {
        "w_mid": first + dot(motion.u, form.midpoint) - form.residual * contact,
        "z_mass": first + device.gap + motion.y,
        "contact_force": contact,
        "axial_force": axial_force,
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
    }
    axis = ("time", time, {"long_name": "time after the start of the pulse", "units": "us"})
    return xr.Dataset(data, {"time": axis}).assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title="Time history of one cell",
        summary="Motion, forces and energies of beam and mass under one shock",
        **provenance(document),
    )
