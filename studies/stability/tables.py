"""The tables of docs/accuracy.md."""

from itertools import product

import numpy as np

from snapmap.files.text import DASH
from snapmap.solver.outcome import FAILED, LATCHED, NEVER, OUTCOMES, RETURNED, SNAPPED, UNSNAPPED

from ..tables import Table
from .cases import MODELS
from .verdicts import CAUGHT, LEFT_OUT, REFUSED, SENSITIVE, SHIFTED, UNSEEN, VERDICTS

MARKS = {
    SENSITIVE: "*{}*",
    SHIFTED: "**shifted** {}",
    CAUGHT: "**caught** {}",
    UNSEEN: "**UNSEEN** {}",
}


def tables(cases, settled):
    """Make the tables of the hard cases and of the settled cells."""
    return default_table(cases), step_table(cases), wrong_table(cases), settled_table(settled)


def default_table(cases):
    """Make a table of the outcome of a sweep for every case (rows) and model (columns)."""
    models = cases.model.values.tolist()
    rows = [
        [case, *(_default_entry(cases.sel(case=case, model=model)) for model in models)]
        for case in cases.case.values
    ]
    return Table("stability", ["case", *MODELS], rows)


def _default_entry(pair):
    verdict = int(pair.default_verdict)
    if verdict in (REFUSED, LEFT_OUT):
        return {REFUSED: "refused", LEFT_OUT: DASH}[verdict]
    outcome, error = OUTCOMES[int(pair.default_outcome)], float(pair.default_energy_error)
    halved = f", dt/{2 ** int(pair.halvings)}" if pair.halvings > 0 else ""
    return MARKS.get(verdict, "{}").format(f"{outcome} {error:.0e}{halved}")


def step_table(cases):
    """Make a table of the number of pairs of case and model with each verdict, for each step."""
    shown = [code for code, name in enumerate(VERDICTS) if name != "unchecked"]
    rows = [
        [f"{step:g}", *_counts(cases.verdict.sel(step=step), shown)] for step in cases.step.values
    ]
    rows.append(["default", *_counts(cases.default_verdict, shown)])
    head = ["step / limit", *(VERDICTS[code] for code in shown)]
    return Table("stability_steps", head, rows)


def _counts(verdicts, shown):
    return [str(int((verdicts == code).sum())) for code in shown]


def wrong_table(cases):
    """Make a table of the believed runs that are wrong, or whose snap time is."""
    at_default = cases[["default_verdict", "default_snap_shift"]].rename(
        default_verdict="verdict", default_snap_shift="snap_shift"
    )
    runs = {f"{step:g}": cases.sel(step=step) for step in cases.step.values}
    rows = []
    for name, run in {**runs, "default": at_default}.items():
        for i, j in zip(*np.nonzero(np.isin(run.verdict, (SHIFTED, UNSEEN))), strict=True):
            pair = run.isel(case=i, model=j)
            verdict, shift = VERDICTS[int(pair.verdict)], f"{pair.snap_shift.item():.1%}"
            rows.append([name, pair.case.item(), pair.model.item(), verdict, shift])
    head = ["step / limit", "case", "model", "verdict", "snap time off by"]
    return Table("stability_wrong", head, rows)


def settled_table(settled):
    """Make a table of the shares of settled, open and reproduced cells, by damping."""
    head = ["damping, 1/µs", "C, µN µs/µm", "do not snap, %", "of these settled", "snap"]
    head += ["of these latched", "returned", "open", "all: failed", "reproduced"]
    head += ["settled: reproduced"]
    rows = [
        [f"{damping:g}", f"{C:g}", *_settled_shares(settled.sel(damping=damping, C=C))]
        for damping, C in product(settled.damping.values, settled.C.values)
    ]
    return Table("stability_settled", head, rows)


def _settled_shares(cells):
    outcome, reproduced = cells.outcome.values, cells.reproduced.values == 1
    quiet = np.isin(outcome, (UNSNAPPED, NEVER))
    snapped = np.isin(outcome, (SNAPPED, LATCHED, RETURNED))
    settled = np.isin(outcome, (NEVER, LATCHED, RETURNED))
    shares = [quiet.mean(), settled[quiet].mean(), snapped.mean()]
    shares += [(outcome[snapped] == code).mean() for code in (LATCHED, RETURNED, SNAPPED)]
    shares += [(outcome == FAILED).mean(), reproduced.mean(), reproduced[settled].mean()]
    return [f"{100 * share:.1f}" for share in shares]
