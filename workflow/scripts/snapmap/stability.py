"""Hard cases: which runs are sound, which are caught, and whether any goes wrong unseen."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from .cells import HALVINGS, follow_cells, follow_once, to_cells
from .config import device_document
from .cube import VARIABLES as CUBE_VARIABLES
from .device import BISTABILITY_LIMIT, Device
from .lanes import LANES
from .modal import step_limit
from .models import build_model
from .outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED, label
from .protocol import Protocol
from .provenance import provenance
from .thresholds import lowest_snap

VERDICTS = (
    *("sound", "sensitive", "shifted", "unchecked", "caught", "unseen"),
    *("refused", "left_out"),
)
SOUND, SENSITIVE, SHIFTED, UNCHECKED, CAUGHT, UNSEEN, REFUSED, LEFT_OUT = range(len(VERDICTS))
"""Up to UNSEEN ever worse: the verdict on several cells is the highest of theirs."""
STEPS = (0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.05)
FINE_STEPS = (0.1, 0.075)
SAME_SNAP = 0.02
"""Two runs snap alike if the times differ by less than this share."""
SAME_PROOF = 0.05
"""Fine runs whose times of proof differ by more than this share are chaotic, whatever they prove.
A proof is looked for every 128 steps only."""
APART = 1e-9
"""The amplitudes of a case's cells lie this share apart."""
SEARCHED = (300.0, 3000.0)
"""Where the threshold is looked for, multiples of g."""
BUDGET = 18.0
"""The steps of a case are left out if they would take longer, s; if one run takes an eighth of it,
the case is."""


class Case(NamedTuple):
    """A cell that is hard on the scheme, with near copies of itself.

    N: multiples of g, or of the model's own threshold if `of_threshold`
    f0: Hz; C: uN us/um; horizon: us followed after the pulse
    contact (uN/um), Q (rise over thickness), beam_damping (1/us): the device's own if None
    cells: how many are followed, each N a share of APART below the one before
    """

    name: str
    N: float
    f0: float = 1500.0
    C: float = 0.025
    horizon: float = 1500.0
    of_threshold: bool = False
    contact: float | None = None
    Q: float | None = None
    beam_damping: float | None = None
    cells: int = LANES


HARD = np.inf
CASES = (
    Case("handout's case", 1000.0),
    Case("five times as strong", 5000.0),
    Case("contact 4e5 N/m", 1000.0, horizon=300.0, contact=4e5),
    Case("hard contact", 1000.0, horizon=300.0, contact=HARD),
    Case("hard contact, C = 0, 20 ms", 1500.0, C=0.0, horizon=2e4, contact=HARD),
    Case("C = 0, 1 s", 1500.0, C=0.0, horizon=1e6),
    Case("1 % below the threshold", 0.99, of_threshold=True),
    Case("at the threshold", 1.0, of_threshold=True),
    Case("1 % above the threshold", 1.01, of_threshold=True),
    Case("f0 = 10 Hz", 1000.0, f0=10.0, horizon=300.0),
    Case("f0 = 100 kHz", 12000.0, f0=1e5, horizon=300.0),
    Case("N = 0", 0.0, f0=1e4, horizon=100.0),
    Case("N = 1e-6", 1e-6, f0=1e4, horizon=100.0),
    Case("N = -1000", -1000.0, f0=5e3, horizon=100.0),
    Case("N = 1e6", 1e6, f0=1e4, horizon=0.0),
    Case("Q 0.01 % above its limit", 300.0, f0=1e4, horizon=50.0, Q=1.0001 * BISTABILITY_LIMIT),
    Case("chaotic", 1500.0, C=25.0, horizon=6000.0, cells=64),
    Case("chaotic, damped beam", 1500.0, C=25.0, horizon=6000.0, beam_damping=4e-4, cells=64),
)
MODELS = {
    "1 cosine": {"name": "cosines", "modes": 1},
    "2 cosines": {"name": "cosines", "modes": 2},
    "3 cosines": {"name": "cosines", "modes": 3},
    "5 cosines": {"name": "cosines", "modes": 5},
    "8 cosines": {"name": "cosines", "modes": 8},
    "12 cosines": {"name": "cosines", "modes": 12},
    "1 element": {"name": "handout", "elements": 1},
    "5 elements": {"name": "handout", "elements": 5},
    "5 elements, HRZ": {"name": "handout", "elements": 5, "mass_matrix": "hrz"},
    "20 elements": {"name": "handout", "elements": 20},
    "20 elements, 4 modes": {"name": "elements", "elements": 20, "modes": 4},
    "plain loop": {"name": "reference"},
}
"""Name and options of each model, by what the figure calls it."""

VARIABLES = {
    "limit": {"long_name": "stability limit of the time step", "units": "us"},
    "outcome": {**CUBE_VARIABLES["outcome"], "long_name": "outcome of the case's first cell"},
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


class Runs(NamedTuple):
    """Runs of one case: outcome, t_snap, t_settled (us), energy_error; arrays of one length."""

    outcome: np.ndarray
    t_snap: np.ndarray
    t_settled: np.ndarray
    energy_error: np.ndarray


NO_RUNS = Runs(*np.empty((4, 0)))


def judge(runs: Runs, fine: Runs) -> np.ndarray:
    """Verdict on each run of one case, by runs of it with fine steps; int8.

    `caught`: it failed, and says so. `unseen`: it is believed, and the fine runs agree on another
    outcome: whether the beam snaps, or in which well it stays for ever. `shifted`: on another
    snap time. `sensitive`: the fine runs disagree among themselves. `unchecked`: there are none.
    """
    fine = Runs(*(values[fine.outcome != FAILED] for values in fine))
    if fine.outcome.size == 0:
        return np.where(runs.outcome == FAILED, CAUGHT, UNCHECKED).astype(np.int8)
    snap_known = np.ptp(_has_snapped(fine).astype(int)) == 0
    time_known = snap_known and _spread(fine.t_snap) < SAME_SNAP
    well_known = time_known and np.ptp(fine.outcome) == 0 and _spread(fine.t_settled) < SAME_PROOF
    wrong = snap_known & (_has_snapped(runs) != _has_snapped(fine)[0])
    both_proven = _is_proven(runs) & _is_proven(fine)[0]
    wrong |= well_known & both_proven & (runs.outcome != fine.outcome[0])
    shifted = time_known & (snap_shift(runs, fine) > SAME_SNAP)
    believed = SOUND if well_known else SENSITIVE
    verdict = np.select(
        [runs.outcome == FAILED, wrong, shifted], [CAUGHT, UNSEEN, SHIFTED], believed
    )
    return verdict.astype(np.int8)


def snap_shift(runs: Runs, fine: Runs) -> np.ndarray:
    """Difference of each run's snap time from the fine runs' median, over it; NaN without one."""
    known = fine.t_snap[np.isfinite(fine.t_snap) & (fine.outcome != FAILED)]
    median = np.median(known) if known.size else np.nan
    return np.where(runs.outcome == FAILED, np.nan, np.abs(runs.t_snap / median - 1))


def _spread(times):
    """Largest difference over the largest time; 0 if there are no times."""
    times = times[np.isfinite(times)]
    return np.ptp(times) / times.max() if times.size else 0.0


def _has_snapped(runs):
    return np.isin(runs.outcome, (SNAPPED, LATCHED, RETURNED))


def _is_proven(runs):
    return np.isin(runs.outcome, (NEVER, LATCHED, RETURNED))


def measure(
    device: Device,
    cases: Sequence[Case] = CASES,
    models: Mapping[str, Mapping] = MODELS,
    steps: Sequence[float] = STEPS,
    threads: int = 1,
) -> xr.Dataset:
    """Follow every case with every model at every step, as shares of its stability limit.

    The variables named default_* hold what a sweep gives: it takes the model's own step, and
    halves it where a ledger does not close.
    """
    pairs = list(product(cases, models.values()))
    with ThreadPoolExecutor(threads) as pool:
        found = list(pool.map(lambda pair: _measure_pair(device, *pair, steps), pairs))
    values = {key: np.array([one[key] for one in found]) for key in found[0]}
    return _dress(device, cases, models, steps, values)


def _measure_pair(device, case, options, steps):
    """The values of one case and one model, by the dataset's names of them."""
    device = changed(device, case)
    try:
        model = build_model(device, **options)
    except ValueError:
        return _blank(steps, REFUSED)
    limit = step_limit(device, model.modal)
    values = _blank(steps, LEFT_OUT) | {"limit": limit, "default_step": model.dt / limit}
    search = [FINE_STEPS[0] * limit] * 4 * case.of_threshold  # a dozen runs, over at the snap
    if _seconds(model, case, [model.dt, *search]) > BUDGET / 8:
        return values
    cells, protocol = _cells(device, model, case, limit), Protocol(case.horizon)

    @cache
    def follow_at(dt):
        return _to_runs(follow_once(device, model._replace(dt=dt), cells, protocol))

    fine = NO_RUNS
    if _seconds(model, case, limit * np.array([*FINE_STEPS, *steps])) < BUDGET:
        fine = Runs(*np.hstack([follow_at(step * limit) for step in FINE_STEPS]))
        at_steps = [_summary(follow_at(step * limit), fine) for step in steps]
        values |= {key: [one[key] for one in at_steps] for key in at_steps[0]}
    final = _to_runs(follow_cells(device, model, cells, protocol))
    values |= {f"default_{key}": value for key, value in _summary(final, fine).items()}
    return values | {"halvings": _halvings(follow_at, model.dt, final)}


def changed(device: Device, case: Case) -> Device:
    """The device that a case asks for."""
    beam = device.beam
    if case.Q is not None:
        beam = replace(beam, rise=case.Q * beam.thickness)
    if case.beam_damping is not None:
        beam = replace(beam, damping=case.beam_damping)
    return replace(device, beam=beam, contact=case.contact or device.contact)


def _seconds(model, case, steps):
    """Expected time of one run at each step (us); only for leaving out what takes too long."""
    modes = model.modal.load.size
    nanoseconds = 40 * LANES if model.name == "reference" else 60 + modes**2
    duration = 1e6 / case.f0 + case.horizon
    groups = np.ceil(case.cells / LANES)
    return float(np.sum(duration / np.array(steps)) * groups * nanoseconds * 1e-9)


def _cells(device, model, case, limit):
    N = case.N
    if case.of_threshold:
        fine = model._replace(dt=FINE_STEPS[0] * limit)
        asked = [case.f0], [case.C], SEARCHED, Protocol(horizon=300.0)
        N *= lowest_snap(device, fine, *asked, tolerance=10 * APART)[0]
    copies = N * (1 - APART * np.arange(case.cells))
    same = np.ones(case.cells)
    return to_cells(device, copies, case.f0 * same, case.C * same, case.horizon)


def _to_runs(facts):
    outcome = label(*facts, Protocol().energy_tolerance)
    return Runs(outcome, facts.t_snap, facts.t_settled, facts.energy_error)


def _blank(steps, verdict):
    """What stands for a case that is not run, and why."""
    one = {"outcome": FAILED, "energy_error": np.nan, "snap_shift": np.nan, "verdict": verdict}
    at_steps = {key: [value] * len(steps) for key, value in one.items()}
    default = {f"default_{key}": value for key, value in one.items()}
    return {"limit": np.nan, "default_step": np.nan, "halvings": -1, **at_steps, **default}


def _summary(runs, fine):
    """The first cell's outcome, and the worst of the others' energy error, shift and verdict."""
    return {
        "outcome": runs.outcome[0],
        "energy_error": np.nan_to_num(runs.energy_error, nan=np.inf).max(),
        "snap_shift": np.fmax.reduce(snap_shift(runs, fine)),
        "verdict": judge(runs, fine).max(),
    }


def _halvings(follow_at, dt, final):
    """How often the step was halved until every cell had the run that it ended with."""
    waiting = np.ones(final.outcome.size, bool)
    for halvings in range(HALVINGS):
        waiting &= follow_at(dt / 2**halvings).energy_error != final.energy_error
        if not waiting.any():
            return halvings
    return HALVINGS


def _dress(device, cases, models, steps, values):
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
        "device": device_document(device),
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
