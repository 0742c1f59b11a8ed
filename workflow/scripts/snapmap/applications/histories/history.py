"""One cell in full: motion, contact force and every energy over time."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...beam.modal import contact_stiffness
from ...beam.stress import stress_of
from ...device.device import Device
from ...files.text import plain
from ...numerics.linalg import dot, multiply
from ...pulse.pulse import blow_at
from ...solver.adaptive import choose_model
from ...solver.cells import Cells, Observations, to_cells
from ...solver.cost import steps_and_seconds, tell
from ...solver.kernel.tables import look_up
from ...solver.models import Model, follow_twice
from ...solver.options import section_of
from ...solver.outcome import label
from ...solver.settings import FIRST, SHOWN, Run
from ...study.arguments import SingleStudy
from ...study.axes import Grid, frequencies, rows_of
from ...study.provenance import device_sections
from ...study.study import Study
from ...study.variables import dress
from ...values.faults import warn
from ...values.quantities import Amplitude, Damper, Frequency, PulseTime
from .. import merge

SAMPLES = 4000
"""A history keeps at least this many instants and less than twice as many, or every step if these
are fewer."""

RECORDED = 700.0
"""Time of a run that records every step, over that of a run of a sweep."""
ERROR_STEPS, SAFETY = (1.0, 0.75, 0.5), 4.0
"""Steps of the runs that tell the error of a history, over its own, and the error over their
spread. Second order gives 4/3; near a threshold the order is lower. See docs/accuracy.md."""
CURE = "write a higher f0 or a shorter horizon"

# ASSUME: a device has room for its mass to travel a few rises; a snap moves it by two rises.
FARTHEST = 5.0
"""Travel of a mass without stops from rest, over the rise of the beam, above which a result is not
valid, and warned of."""


def simulate(
    study: SingleStudy,
    N: Amplitude,
    f0: Frequency | None,
    C: Damper,
    *,
    duration: PulseTime | None = None,
) -> xr.Dataset:
    """Follow a single cell to the horizon, beyond its snap, and return its history over time.

    Of the models of `auto` the finest is used; `energy_tolerance` only sets the time step.

    Parameters
    ----------
    study
        Device, model, shock, and how the cell is followed; or a Device.
    N
        Amplitude of the shock, multiples of g.
    f0
        Frequency of the pulse, Hz; None for a recorded shock.
    C
        Damping of the mass, uN us/um.
    duration
        Duration of the pulse, us, in place of f0.

    Returns
    -------
    Dataset
        The motion over `time` (us), in shorter steps than those of a sweep. Single numbers are
        `outcome` (a code, as in a cube), `t_snap` (us, NaN without a snap), the largest travel of
        the mass from rest (`toward_max`, `away_max`, um), force (`contact_force_max`, uN) and
        stress (`stress_max`, MPa), and the errors `work_error` (relative) and `t_snap_error` (us).

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, if the study has several devices or shocks.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", horizon=0)
    >>> run = snapmap.simulate(study, 1100, "1.5 kHz", 25)
    >>> snapmap.words(run.outcome).item(), round(run.t_snap.item())
    ('snapped', 365)
    """
    f0 = frequencies(f0, duration)
    return history_of(study, N, study.shocks.own_frequency() if f0 is None else f0, C)


def history_of(study: Study, N: float, f0: float, C: float) -> xr.Dataset:
    """Follow one cell of a study of one device and pulse, as `simulate` does."""
    device, settings = study.device, study.run.but(until=SHOWN)
    built, cells, observed = _cell(study, N, f0, C, SHOWN)
    outcome = label(observed, settings.energy_tolerance).item()
    dt, values, extremes = _record(built, cells, settings, SAMPLES)
    warn_of_travel(free_travel(device, *extremes[:2]))
    document = {
        **device_sections(device),
        **study.shocks.section(),
        "model": section_of(study.model),
        "histories": [{"N": N, "f0": f"{f0!r} Hz", "C": f"{C!r} {study.unit_of_C}".strip()}],
    }
    single = {
        "second_equilibrium": built.barrier.second,
        "barrier": built.barrier.energy,
        "gravity": device.gravity,
        "time_step": dt,
        "outcome": np.int8(outcome),
        "t_snap": observed.t_snap.item(),
        **extremes._asdict(),
    }
    if settings.start != FIRST:
        document["run"] = {"start": settings.start}
        single["first_equilibrium"] = built.barrier.first
    rest = built.barrier.first + device.gap
    stops = {"stop_toward": rest - device.stop_toward, "stop_away": rest + device.stop_away}
    single |= {key: place for key, place in stops.items() if math.isfinite(place)}
    if cells.pulses[0].blows.size:
        single["blow"] = blow_at(cells.pulses, cells.pulse, observed.t_snap * cells.f0).item()
    single |= merge(lambda part: part.in_history(built, cells, settings))
    single |= {key: error.item() for key, error in errors_of(built, cells, settings).items()}
    curves = {key: ("time", column) for key, column in values.items()}
    shock = {"N": float(N), "f0": float(f0), "C": float(C)}
    return dress("history", xr.Dataset(curves | single, shock), document)


class Extremes(NamedTuple):
    """Largest values under one shock, over all steps up to the horizon.

    toward_max, away_max: travel of the mass from rest, toward the beam and away from it, um
    contact_force_max: force between mass and beam, uN; only an indicator
    stress_max, stress_max_to_snap: tensile stress in the beam, MPa; the latter until it snaps
    The first three are NaN for a beam alone.
    """

    toward_max: float
    away_max: float
    contact_force_max: float
    stress_max: float
    stress_max_to_snap: float


def extremes_of(study: Study, N: float, f0: float, C: float, step: float = 1.0) -> Extremes:
    """Find the extremes of one cell of a study of one device and pulse.

    step: time step over the default one
    """
    built, cells, _ = _cell(study, N, f0, C, "moved")
    return _record(built.with_step(step), cells, study.run, samples=1)[-1]


def observed_of(study: Study, N: float, f0: float, C: float) -> tuple[Extremes, dict[str, float]]:
    """Find the extremes of one cell, and what other applications add to its history, by name."""
    built, cells, _ = _cell(study, N, f0, C, "moved")
    extremes = _record(built, cells, study.run, samples=1)[-1]
    added = merge(lambda part: part.in_history(built, cells, study.run))
    return extremes, added


def _cell(
    study: Study, N: float, f0: float, C: float, until: str
) -> tuple[Any, Cells, Observations]:
    """The model at the step of a cell's motion, the cell, and its `Observations` in that step."""
    horizon, pulses = study.horizon, study.shocks.pulses
    cells = to_cells(study.device, [0], [N], [f0], [C], horizon, 0, pulses)
    model = choose_model(study.device, study.model, study.start).levels[-1]
    moved = study.run.but(until=until)
    seconds = steps_and_seconds(model, cells, moved)[1].item()
    tell("simulate", RECORDED * seconds, f"f0 = {f0:g} Hz", CURE)
    observed = model.follow(cells, moved)
    return model.with_step(math.ldexp(1.0, -observed.halvings.item())), cells, observed


def _record(built, cells, settings, samples):
    """Follow a cell; returns the time step, us, its values over time by name, and its extremes.

    samples: least number of instants to keep; the stride between them is a power of two of steps
    """
    from .motion import record  # imported when a run begins: a plan needs no compiler

    dt = built.time_steps(cells, settings.but(until="moved"))
    steps, start = np.ceil(cells.t_end / dt).item(), settings.start
    stride = 1 << (max(1, int(steps / samples)).bit_length() - 1)
    shock, device, first = cells.pulses[0], built.device, built.barrier.first
    form, motions = record(built, cells, dt, start, jumps=samples == 1)
    side = 1 if start == FIRST else -1
    target = built.snap_target(start) + side * first
    stress, rest = stress_of(device.beam, built.basis, form.shapes), first + device.gap
    largest, to_snap, snapped = np.array([0.0, 0.0, 0.0, -np.inf]), -np.inf, False
    kept, done, last = [], 0, np.empty((2, 0))
    for motion in motions:
        values = _observe(device, first, form, stress, motion, built)
        y = values["z_mass"] - rest
        force = math.nan if device.is_alone else values["contact_force"].max()
        largest = np.maximum(largest, [-y.min(), y.max(), force, values["stress"].max()])
        if not snapped:
            path = np.append(last, [side * values["w_mid"], values["stress"]], axis=1)
            most, snapped = _stress_to(target, *path)
            to_snap, last = np.maximum(to_snap, most), path[:, -1:]
        values |= {"time": motion.time, "dissipated_energy": motion.lost, "pulse_work": motion.work}
        kept.append({key: column[-done % stride :: stride] for key, column in values.items()})
        done += motion.time.size
    extremes = Extremes(*largest.tolist(), float(to_snap))
    values = {key: np.concatenate([part[key] for part in kept]) for key in kept[0]}
    shaken = cells.amplitude * shock.at(cells.f0 * values["time"])
    if device.force:
        values["midpoint_force"] = shaken / device.gravity * device.force
    else:
        values["acceleration"] = shaken
    return dt.item(), values, extremes


def _stress_to(target, w, stress):
    """The largest stress until w falls to the target, and whether it does."""
    beyond = np.flatnonzero(w <= target)
    if not beyond.size:
        return stress.max(), False
    # Under a hard shock the stress still rises when the beam snaps, between two steps.
    i = beyond[0]
    share = (w[i - 1] - target) / (w[i - 1] - w[i])
    at_snap = stress[i - 1] + share * (stress[i] - stress[i - 1])
    return np.maximum(stress[:i].max(), at_snap), True


def errors_of(model: Model, cells: Cells, settings: Run) -> dict[str, np.ndarray]:
    """Find `work_error`, relative, and `t_snap_error`, us, of the motion of cells, (cells,).

    NaN where not all runs know the work, or snap.
    """
    moved = settings.but(until="moved")
    models = [model.with_step(share) for share in ERROR_STEPS]
    runs = onward = [each.follow_once(cells, moved) for each in models]
    if model.name == "reference":  # no snap is to end a run before its pulse is over
        barrier = model.barrier._replace(second=-np.inf)
        onward = [replace(each, barrier=barrier).follow_once(cells, moved) for each in models]
    work = np.array([run.pulse_work for run in onward])
    spread, largest = np.ptp(work, axis=0), abs(work).max(axis=0)
    return {
        "work_error": SAFETY * np.divide(spread, largest, out=spread, where=largest > 0),
        "t_snap_error": SAFETY * np.ptp([run.t_snap for run in runs], axis=0),
    }


def _observe(device, first, form, stress, motion, built):
    """Deflections, forces and energies from the coordinates; first: w(L/2) at rest, um.

    Under a user's own law of beam or contact, what the law does not tell is NaN.
    """
    velocity, laws, tables = motion.u_velocity, built.laws, built.tables
    stiffness = contact_stiffness(device, form.residual)
    overlap = dot(motion.u, form.midpoint) - motion.y - device.gap
    contact = stiffness * np.maximum(0.0, overlap)
    stored = contact**2 / (2 * stiffness)
    if tables and tables.contact[0]:
        stored, contact = look_up(tables.values[tables.contact[0]], tables.reach[0], overlap)
    axial_force = -device.beam.axial_stiffness * motion.stretch
    rest = math.nan if device.is_alone else first + device.gap
    kinetic = dot(velocity, multiply(velocity, form.inertia)) / 2
    values = {
        "w_mid": first + dot(motion.u, form.midpoint) - form.residual * contact,
        # In the step of a bounce, the mean of both ends lies beyond the stop.
        "z_mass": rest + np.clip(motion.y, -device.stop_toward, device.stop_away),
        "contact_force": contact,
        "axial_force": axial_force,
        "stress": stress.largest(motion.u, contact, axial_force),
        "kinetic_energy": kinetic + device.mass * motion.y_velocity**2 / 2,
        "spring_energy": device.spring * motion.y**2 / 2,
        "bending_energy": dot(motion.u, multiply(motion.u, form.bending)) / 2,
        "axial_energy": axial_force**2 / (4 * device.beam.axial_stiffness),
        "contact_energy": stored,
    }
    of_beam = "axial_force", "stress", "bending_energy", "axial_energy"
    unknown = of_beam if laws and laws.force else ()
    return values | {key: values[key] + math.nan for key in unknown}


def free_travel(device: Device, toward_max: float, away_max: float) -> float:
    """Return the travel of a mass on the sides without a stop, um, over the rise of the beam."""
    toward = toward_max if np.isinf(device.stop_toward) else 0.0
    away = away_max if np.isinf(device.stop_away) else 0.0
    return float(max(toward, away) / device.beam.height)


def warn_of_travel(rises: float, where: str = "") -> None:
    """Warn, in one line, if the largest `free_travel` is beyond FARTHEST; where: in which runs."""
    if rises > FARTHEST:
        warn(
            f"the mass travels up to {plain(rises, 3)} times the rise{where}, outside any package "
            f"(above {FARTHEST:g}): not valid; if the frame is nearer, write device.stop_toward, "
            "device.stop_away or both",
        )


# ASSUME: a shock machine repeats its peak to 1 % at best, so a beam that must stay has to stay at
# these factors of N, too.
NEAR = 1 + np.arange(-10, 11) / 1000


def follow_near(study: Study, grid: Grid, N: Sequence[float]) -> list[Observations]:
    """Follow the rows of a grid to the end twice, at each N by the finest level.

    Returns observations, (rows, N), of each step.
    """
    settings = study.run.but(until="settled")
    cells = rows_of(grid).cells(grid.device, N, settings.horizon)
    finest = choose_model(grid.device, study.model, settings.start).levels[-1]
    return follow_twice(finest, cells, settings)
