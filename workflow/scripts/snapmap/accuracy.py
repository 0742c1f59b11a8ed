"""Every source of error of a simulation, measured one at a time, and the time it takes.

Asked of every case: the lowest N that snaps, the time of the snap a little above it, and which
cells of a map snap. Its answers are held against a converged run, whose own error is estimated by
refinement, or, for the step and the horizon, against the finest step and the longest horizon.
All arithmetic is in double precision; single precision is not offered.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import NamedTuple

import numpy as np
import xarray as xr

from .cells import follow_cells, to_cells
from .config import device_document
from .device import Device
from .grid import follow_grid
from .models import Model, build_model
from .protocol import Protocol
from .provenance import provenance
from .thresholds import lowest_snap

FAMILIES = (
    "elements_consistent",
    "elements_hrz",
    "cosines",
    "cosines_uncorrected",
    "step",
    "penalty",
    "horizon",
)
MODELS = FAMILIES[:4]
"""Families of models: of one device, followed alike, and so to be ranked."""
QUANTITIES = {"threshold": ("lowest N that snaps", "1"), "t_snap": ("time of the snap", "us")}
LABELS = "share of cells with another label"
CONVERGED, HARD = "converged", "converged, hard contact"

TOLERANCE = 1e-6
"""To which thresholds are refined, relative."""
ABOVE = 1.05
"""The time of the snap is taken at this multiple of the case's own threshold."""
DECIDED = 1e-3
"""A converged value faults no case unless its own relative error is below this."""
FINE_STEP = 0.2
"""Step of the converged runs, as a fraction of the stability limit."""
# ASSUME: central differences are of order 2; kept modes were never seen to converge more slowly.
ORDER, MESH_ORDER = 2, 4
SAFETY = 2.0
"""An own error is so many times what Richardson's formula leaves after a refinement."""
ROUNDS, SLOW = 3, 0.5
"""Maps that take less than SLOW seconds are timed again, in so many rounds over all of them."""


class Refinement(NamedTuple):
    """Of a converged run.

    cosines: of the run itself, and fewer to estimate its error
    meshes, modes: the same of the other discretisation: elements, and modes kept; () for none
    """

    cosines: tuple[int, int]
    meshes: tuple[int, ...] = ()
    modes: tuple[int, ...] = ()


class Plan(NamedTuple):
    """What is compared.

    elements, cosines: numbers of them; all modes are kept, but of elements at most `most_modes`
    steps: fractions of the stability limit, the finest first
    penalties: multiples of the device's contact, beside hard contact
    horizons: multiples of the protocol's, the longest last
    converged, hard: refinement of the converged run, and of that with hard contact
    side: cells of the map along N and f0
    """

    elements: tuple[int, ...]
    most_modes: int
    cosines: tuple[int, ...]
    steps: tuple[float, ...]
    penalties: tuple[float, ...]
    horizons: tuple[float, ...]
    converged: Refinement
    hard: Refinement
    side: int


PLANS = {
    # All 39 modes of 20 elements would take a minute for each map.
    "full": Plan(
        elements=(3, 5, 10, 20),
        most_modes=19,
        cosines=(2, 3, 4, 5, 6, 8),
        steps=(0.1, 0.2, 0.4, 0.6, 0.8, 1.0),
        penalties=(1, 10, 100),
        horizons=(0, 0.3, 1, 3),
        converged=Refinement((16, 12), (20, 10), (12, 8)),
        hard=Refinement((12, 8), (20, 10), (12, 8)),
        side=24,
    ),
    # Three numbers of modes, 3, 5 and 9: for each a kernel is compiled.
    "quick": Plan(
        elements=(3, 5),
        most_modes=9,
        cosines=(3, 5),
        steps=(0.4, 0.8),
        penalties=(1, 10, 100),
        horizons=(0, 1),
        converged=Refinement((9, 5)),
        hard=Refinement((5, 3)),
        side=16,
    ),
}


class Probe(NamedTuple):
    """What every case is asked.

    C (uN us/um), f0 (Hz): of the thresholds; bracket: multiples of g between which they lie
    axes: of the map, in the order of `grid.AXES`
    """

    C: np.ndarray
    f0: np.ndarray
    bracket: tuple[float, float]
    axes: tuple[np.ndarray, ...]


class Case(NamedTuple):
    """A way to simulate, and the name of what its answer is held against."""

    name: str
    family: str
    device: Device
    model: Model
    protocol: Protocol
    against: str


class Answer(NamedTuple):
    """What was found.

    values: of QUANTITIES, in multiples of g and in us, (2, C, f0)
    t_snap: of the map, us, (C, f0, N)
    seconds: per simulation of the map, on one thread
    """

    values: np.ndarray
    t_snap: np.ndarray
    seconds: float


class Converged(NamedTuple):
    """A converged run and its own error; the same of another discretisation, NaN if not planned.

    error, other, other_error: as `Answer.values`
    repeated: t_snap of the map with twice the step
    """

    answer: Answer
    error: np.ndarray
    other: np.ndarray
    other_error: np.ndarray
    repeated: np.ndarray


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
    for case in cases:
        answers[case.name] = answer(case, probe, threads)
    # In rounds, so that whatever else the machine does for a while slows no case alone.
    for case in cases * ROUNDS:
        answers[case.name] = least_seconds(case, answers[case.name], probe)
    document = {
        "device": device_document(device),
        "sweep": protocol._asdict() | {"horizon": f"{protocol.horizon!r} us"},
        "accuracy": plan._asdict(),
    }
    return dress(cases, answers, converged, probe).assign_attrs(provenance(document))


def make_probe(axes: Sequence[Sequence[float]], side: int) -> Probe:
    """Choose what to ask: thresholds at both ends of C and the quarter points of f0, and a map.

    The bracket reaches from half the least |N| to twice the largest.
    """
    C, f0, N = (np.sort(np.asarray(values, float)) for values in axes)
    ends = np.unique(C[[0, -1]])
    quarters = np.round(np.array([0.25, 0.5, 0.75]) * (f0.size - 1)).astype(int)
    sizes = np.abs(N[N != 0]) if N.any() else np.ones(1)
    wide = np.unique(np.geomspace(f0[0], f0[-1], side)), np.unique(np.linspace(N[0], N[-1], side))
    bracket = float(sizes.min() / 2), float(2 * sizes.max())
    return Probe(ends, f0[np.unique(quarters)], bracket, (ends, *wide))


def list_cases(device: Device, protocol: Protocol, plan: Plan) -> Iterator[Case]:
    """Every case of a plan; each family changes one thing and leaves the others alone."""
    for name, family, model in (*_elements(device, plan), *_cosines(device, plan)):
        yield Case(name, family, device, model, protocol, CONVERGED)
    for step in plan.steps:
        model = build_model(device, "handout", step=step)
        yield Case(f"step {step:g}", "step", device, model, protocol, f"step {plan.steps[0]:g}")
    for factor in (*plan.penalties, math.inf) if math.isfinite(device.contact) else ():
        stiff = replace(device, contact=factor * device.contact)
        model = build_model(stiff, "cosines", modes=plan.cosines[-1])
        yield Case(f"contact x {factor:g}", "penalty", stiff, model, protocol, HARD)
    for factor in plan.horizons:
        longer = protocol._replace(horizon=factor * protocol.horizon)
        longest = f"horizon x {plan.horizons[-1]:g}"
        model = build_model(device, "handout")
        yield Case(f"horizon x {factor:g}", "horizon", device, model, longer, longest)


def _elements(device, plan):
    for mass in ("consistent", "hrz"):
        for n in plan.elements:
            name, options = f"{n} elements, {mass}", {"elements": n, "mass_matrix": mass}
            if 2 * n - 1 > plan.most_modes:
                name, options["modes"] = f"{name}, {plan.most_modes} modes", plan.most_modes
            yield name, f"elements_{mass}", build_model(device, "elements", **options)


def _cosines(device, plan):
    models = {n: build_model(device, "cosines", modes=n) for n in plan.cosines}
    for n, model in models.items():
        yield f"{n} cosines", "cosines", model
    # Without it, hard contact would have no finite stiffness.
    for n, model in models.items() if math.isfinite(device.contact) else ():
        plain = model._replace(modal=model.modal._replace(residual=0.0))
        yield f"{n} cosines, uncorrected", "cosines_uncorrected", plain


def answer(case: Case, probe: Probe, threads: int = 1) -> Answer:
    """Ask a case everything; the thresholds come first, so that the map finds compiled code."""
    values = ask(case.device, case.model, probe, case.protocol, threads)
    return Answer(values, *follow_map(case.device, case.model, probe, case.protocol))


def ask(
    device: Device, model: Model, probe: Probe, protocol: Protocol, threads: int = 1
) -> np.ndarray:
    """Lowest N that snaps, in multiples of g, and t_snap at ABOVE times that, us; (2, C, f0)."""
    C, f0 = (values.ravel() for values in np.meshgrid(probe.C, probe.f0, indexing="ij"))
    lowest = lowest_snap(device, model, f0, C, probe.bracket, protocol, TOLERANCE, threads)
    cells = to_cells(device, np.nan_to_num(ABOVE * lowest), f0, C, protocol.horizon)
    t_snap = follow_cells(device, model, cells, protocol, threads).t_snap
    return np.reshape([lowest, t_snap], (2, probe.C.size, probe.f0.size))


def follow_map(
    device: Device, model: Model, probe: Probe, protocol: Protocol
) -> tuple[np.ndarray, float]:
    """t_snap of the map's cells, us, (C, f0, N), and the seconds that each took."""
    start = perf_counter()
    t_snap = follow_grid(device, model, probe.axes, protocol)["t_snap"]
    return t_snap, (perf_counter() - start) / t_snap.size


def least_seconds(case: Case, found: Answer, probe: Probe) -> Answer:
    """Take the time of another run of the map if that is less; a slow map is not run again."""
    if found.seconds * found.t_snap.size > SLOW:
        return found
    _, seconds = follow_map(case.device, case.model, probe, case.protocol)
    return found._replace(seconds=min(seconds, found.seconds))


def converge(
    device: Device, probe: Probe, protocol: Protocol, refinement: Refinement, threads: int = 1
) -> Converged:
    """Ask many cosines, in fine steps, and as many elements, and estimate what is left of error."""

    def refined(name, modes, step=FINE_STEP, **options):
        model = build_model(device, name, modes=modes, step=step, **options)
        return ask(device, model, probe, protocol, threads)

    fine, error = _refine(refined, "cosines", *refinement.cosines)
    other, other_error = np.full((2, *fine.shape), np.nan)
    if refinement.meshes:
        other, other_error = _refine_elements(refined, refinement)
    model = build_model(device, "cosines", modes=refinement.cosines[0], step=FINE_STEP)
    found = Answer(fine, *follow_map(device, model, probe, protocol))
    repeated, _ = follow_map(device, model.with_step(2), probe, protocol)
    return Converged(found, error, other, other_error, repeated)


def _refine(refined, name, many, fewer, **options):
    """Values with many modes, and their own error by fewer and by twice the step."""
    fine = refined(name, many, **options)
    by_modes = remainder(fine, refined(name, fewer, **options), many / fewer, ORDER)
    by_step = remainder(fine, refined(name, many, 2 * FINE_STEP, **options), 2, ORDER)
    return fine, SAFETY * (np.abs(by_modes) + np.abs(by_step)) + TOLERANCE * fine


def _refine_elements(refined, refinement):
    """The same of elements, with Richardson's value from two meshes."""
    fine_mesh, coarse_mesh = refinement.meshes
    fine, error = _refine(refined, "elements", *refinement.modes, elements=fine_mesh)
    coarse = refined("elements", refinement.modes[0], elements=coarse_mesh)
    added = remainder(fine, coarse, fine_mesh / coarse_mesh, MESH_ORDER)
    return fine + added, error + np.abs(added)


def remainder(fine: np.ndarray, coarse: np.ndarray, ratio: float, order: int) -> np.ndarray:
    """What Richardson's formula adds to `fine`, found with `ratio` times the resolution."""
    return (fine - coarse) / (ratio**order - 1)


def pareto_front(time: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Whether no other is as fast and accurate, and better in one of them; never for NaN; (n,)."""
    as_good = (time[:, None] <= time) & (error[:, None] <= error)
    better = (time[:, None] < time) | (error[:, None] < error)
    return ~(as_good & better).any(axis=0) & np.isfinite(time + error)


def dress(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    converged: Mapping[str, Converged],
    probe: Probe,
) -> xr.Dataset:
    """Hold every case against its reference and return all of it, with CF attributes."""
    family = np.array([FAMILIES.index(case.family) for case in cases], np.int8)
    coordinates = {
        "model": [case.name for case in cases],
        "family": _flags("model", family, "family of cases that differ in one thing", FAMILIES),
        "against": ("model", [case.against for case in cases], {"long_name": "held against"}),
        "reference": list(converged),
        "C": _variable("C", probe.C, "damping coefficient of the mass", "uN us um-1"),
        "f0": _variable("f0", probe.f0, "frequency of the pulse", "Hz"),
    }
    variables = _comparison(cases, answers, converged, probe) | _references(converged, probe)
    return xr.Dataset(variables, coordinates).assign_attrs(
        Conventions="CF-1.11",
        title="Error from each source, and the time that a simulation takes",
        discretisations_gap=max(gap(run) for run in converged.values()),
    )


def gap(run: Converged) -> float:
    """Largest difference of the two discretisations over the sum of their own errors; NaN for none.

    They agree if it is at most 1. Only what is decided counts.
    """
    apart = np.abs(run.answer.values - run.other) / (run.error + run.other_error)
    return float(np.max(apart[decided(run)], initial=0.0))


def decided(run: Converged) -> np.ndarray:
    """Where the converged values are known well enough to fault others, (2, C, f0).

    No snap is timed above a threshold that is not known.
    """
    return np.logical_and.accumulate(run.error < DECIDED * run.answer.values)


def disagreement(t_snap: np.ndarray, reference: np.ndarray, f0: np.ndarray) -> tuple[float, float]:
    """Share of cells labelled otherwise (snaps or not), of all and of those that snap in the pulse.

    t_snap, reference: us, (C, f0, N), NaN for no snap; the reference tells which cells snap in
    the pulse; NaN where none does. f0: Hz
    """
    other = np.isnan(t_snap) != np.isnan(reference)
    in_pulse = reference < 1e6 / f0[:, np.newaxis]
    return other.mean(), other[in_pulse].mean() if in_pulse.any() else np.nan


def summary(found: xr.Dataset) -> str:
    """One line: the models that none beats, and how many thresholds could be decided."""
    front = found.isel(model=np.flatnonzero(found.on_front))
    points = zip(front.model.values, front.threshold_worst.values, strict=True)
    known = int(found.threshold_decided.sum()), found.threshold_decided.size
    best = ", ".join(f"{name} ({worst:.1e})" for name, worst in points)
    return f"not beaten {best or 'none'}; {known[0]} of {known[1]} thresholds are well posed"


def _comparison(cases, answers, converged, probe):
    """The variables along `model`."""
    found = [(answers[case.name], answers[case.against]) for case in cases]
    values = np.array([one.values for one, _ in found])
    errors = values / np.array([other.values for _, other in found]) - 1
    known = [decided(converged.get(case.against, converged[CONVERGED])) for case in cases]
    worst = _worst(errors, np.array(known))
    labels = [disagreement(one.t_snap, other.t_snap, probe.axes[1]) for one, other in found]
    all_cells, in_pulse = np.transpose(labels)
    seconds = np.array([one.seconds for one, _ in found])
    ranked = [case.family in MODELS for case in cases]
    front = pareto_front(np.where(ranked, seconds, np.nan), worst[:, 0]).astype(np.int8)
    modes = [case.model.modal.load.size for case in cases]
    contact = [case.device.contact for case in cases]
    variables = {
        "modes": _variable("model", modes, "number of modes", "1"),
        "step": _variable("model", [case.model.dt for case in cases], "time step", "us"),
        "contact": _variable("model", contact, "contact penalty; inf: hard", "uN um-1"),
        "time_per_simulation": _variable("model", seconds * 1e6, "time per cell of the map", "us"),
        "simulations_per_second": _variable("model", 1 / seconds, "cells of the map per s", "s-1"),
        "on_front": _flags("model", front, "no model is faster and more accurate", ("no", "yes")),
        "label_error": _variable("model", all_cells, f"{LABELS}, of all cells", "1"),
        "label_error_in_pulse": _variable("model", in_pulse, f"{LABELS} in the pulse", "1"),
    }
    for i, (key, (name, unit)) in enumerate(QUANTITIES.items()):
        variables[key] = _variable(("model", "C", "f0"), values[:, i], name, unit)
        relative = f"error of the {name}, relative"
        variables[f"{key}_error"] = _variable(("model", "C", "f0"), errors[:, i], relative, "1")
        variables[f"{key}_worst"] = _variable("model", worst[:, i], f"largest {relative}", "1")
    return variables


def _references(converged, probe):
    """The variables along `reference`."""
    runs, dims = list(converged.values()), ("reference", "C", "f0")
    labels = [disagreement(r.repeated, r.answer.t_snap, probe.axes[1])[0] for r in runs]
    seconds = [run.answer.seconds * 1e6 for run in runs]
    variables = {
        "converged_time": _variable("reference", seconds, "time per cell of the map", "us"),
        "converged_label_error": _variable("reference", labels, f"{LABELS} at twice the step", "1"),
    }
    columns = {
        "converged_{}": ([run.answer.values for run in runs], "{}"),
        "converged_{}_error": ([run.error for run in runs], "own error of the {}"),
        "elements_{}": ([run.other for run in runs], "{}, by elements"),
        "elements_{}_error": (
            [run.other_error for run in runs],
            "own error of the {}, by elements",
        ),
    }
    known = np.array([decided(run) for run in runs], np.int8)
    for i, (key, (name, unit)) in enumerate(QUANTITIES.items()):
        for column, (values, text) in columns.items():
            values = np.array(values)[:, i]
            variables[column.format(key)] = _variable(dims, values, text.format(name), unit)
        text = f"whether the {name} is known well enough to fault a model"
        variables[f"{key}_decided"] = _flags(dims, known[:, i], text, ("no", "yes"))
    return variables


def _worst(errors, known):
    """Largest |error| where it is known, (model, 2); NaN if nowhere, or where a case found none."""
    worst = np.where(known, np.abs(errors), -np.inf).max(axis=(2, 3))
    return np.where(np.isneginf(worst), np.nan, worst)


def _variable(dims, values, long_name, units):
    return dims, np.asarray(values), {"long_name": long_name, "units": units}


def _flags(dims, values, long_name, meanings):
    flags = np.arange(len(meanings), dtype=np.int8)
    meanings = {"flag_values": flags, "flag_meanings": " ".join(meanings)}
    return dims, values, {"long_name": long_name} | meanings
