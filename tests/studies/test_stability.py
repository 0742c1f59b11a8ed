"""The hard cases: what a verdict means, and that by default nothing goes wrong unseen."""

import numpy as np
import pytest

from snapmap.solver.outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED, UNSNAPPED
from studies.stability import tables
from studies.stability.cases import CASES, MODELS, Case
from studies.stability.figures import LOOKS, exponent
from studies.stability.measure import measure
from studies.stability.verdicts import (
    CAUGHT,
    LEFT_OUT,
    NO_RUNS,
    REFUSED,
    SENSITIVE,
    SHIFTED,
    SOUND,
    UNCHECKED,
    UNSEEN,
    VERDICTS,
    Runs,
    judge,
)

NAN = np.nan
SHORT = (
    *("handout's case", "five times as strong", "contact 4e5 N/m", "hard contact"),
    *("1 % below the threshold", "at the threshold", "1 % above the threshold", "f0 = 100 kHz"),
    *("N = 0", "N = 1e-6", "N = -1000", "N = 1e6", "Q 0.01 % above its limit"),
)


def runs(*each):
    """Runs of (outcome, t_snap, t_settled), whose ledgers close unless they failed."""
    return Runs(*np.array(each, float).T, np.zeros(len(each)))


def verdict(one, *fine):
    return int(judge(runs(one), runs(*fine) if fine else NO_RUNS)[0])


NEVER_RUN = (NEVER, NAN, 700.0)
SNAP_RUN = (SNAPPED, 400.0, NAN)
LATCHED_RUN = (LATCHED, 400.0, 2000.0)


@pytest.mark.parametrize("run", [NEVER_RUN, SNAP_RUN, LATCHED_RUN, (UNSNAPPED, NAN, NAN)])
def test_a_run_like_its_fine_ones_is_sound(run):
    assert verdict(run, run, run) == SOUND


@pytest.mark.parametrize(
    ("one", "fine"),
    [
        (SNAP_RUN, NEVER_RUN),
        (NEVER_RUN, SNAP_RUN),
        ((UNSNAPPED, NAN, NAN), LATCHED_RUN),
        ((RETURNED, 400.0, 2000.0), LATCHED_RUN),
    ],
)
def test_a_believed_run_that_fine_ones_contradict_is_unseen(one, fine):
    assert verdict(one, fine, fine) == UNSEEN


@pytest.mark.parametrize(
    ("one", "fine"),
    [
        ((UNSNAPPED, NAN, NAN), NEVER_RUN),
        (SNAP_RUN, LATCHED_RUN),
        (LATCHED_RUN, SNAP_RUN),
    ],
)
def test_an_open_label_contradicts_no_proof(one, fine):
    assert verdict(one, fine, fine) == SOUND


def test_what_failed_is_caught_whatever_the_fine_runs_say():
    failed = (FAILED, 400.0, NAN)
    assert verdict(failed, SNAP_RUN) == verdict(failed, NEVER_RUN) == verdict(failed) == CAUGHT


def test_a_snap_at_another_time_is_shifted():
    assert verdict((SNAPPED, 407.0, NAN), SNAP_RUN) == SOUND
    assert verdict((SNAPPED, 409.0, NAN), SNAP_RUN) == SHIFTED


@pytest.mark.parametrize(
    "fine",
    [
        (LATCHED_RUN, (RETURNED, 400.0, 2000.0)),
        (LATCHED_RUN, (LATCHED, 400.0, 3000.0)),
        (SNAP_RUN, (SNAPPED, 440.0, NAN)),
        (SNAP_RUN, NEVER_RUN),
    ],
)
def test_where_fine_runs_differ_no_run_is_wrong(fine):
    assert verdict(LATCHED_RUN, *fine) == SENSITIVE
    assert verdict((RETURNED, 400.0, 2000.0), *fine) == SENSITIVE


def test_a_chaotic_well_does_not_excuse_a_missing_snap():
    assert verdict(NEVER_RUN, LATCHED_RUN, (RETURNED, 400.0, 2000.0)) == UNSEEN


def test_without_fine_runs_that_closed_a_run_is_unchecked():
    assert verdict(SNAP_RUN) == verdict(SNAP_RUN, (FAILED, NAN, NAN)) == UNCHECKED


@pytest.fixture(scope="module")
def cheap(handout):
    """The short cases with two cheap models of the kernel and the plain loop, at a few steps."""
    cases = [case for case in CASES if case.name in SHORT]
    models = {name: MODELS[name] for name in ("5 cosines", "5 elements")}
    models["reference"] = {"name": "reference", "elements": 2}
    return measure(handout, cases, models, steps=(0.4, 1.0, 1.5), threads=2)


def test_nothing_goes_wrong_unseen_at_the_default_step(cheap):
    """Nor fails: the halved steps are enough for every one of these cells."""
    assert cheap.sizes["case"] == len(SHORT)
    cheap = cheap.drop_sel(case="hard contact")  # refused by the reference
    assert (cheap.default_verdict < CAUGHT).all()
    assert (cheap.default_energy_error <= 1e-3).all()
    assert (cheap.halvings >= 0).all()


def test_a_step_over_the_limit_is_caught(cheap):
    assert (cheap.verdict != UNSEEN).all()
    beyond = cheap.sel(model="reference", step=1.5).drop_sel(case=["N = 0", "hard contact"])
    assert (beyond.verdict == CAUGHT).all()


def test_no_pulse_no_energy_error(cheap):
    assert not cheap.energy_error.sel(case="N = 0").any()


def test_stiff_contact_sets_the_limit_of_the_reference_alone(cheap):
    stiff, soft = (cheap.limit.sel(case=case) for case in ("contact 4e5 N/m", "handout's case"))
    assert stiff.sel(model="reference") < 0.2 * soft.sel(model="reference")
    assert stiff.sel(model="5 elements") == soft.sel(model="5 elements")


def test_what_a_model_refuses_is_said_so(handout):
    hard = [case for case in CASES if case.name == "hard contact"]
    refused = measure(handout, hard, {"plain": MODELS["reference"]}, steps=(0.8,))
    assert (refused.verdict == REFUSED).all() and (refused.default_verdict == REFUSED).all()


def test_what_takes_too_long_is_left_out(handout):
    long = [Case("a minute", 1500.0, C=0.0, horizon=6e7)]
    found = measure(handout, long, {"5 elements": MODELS["5 elements"]}, steps=(0.8,))
    assert (found.default_verdict == LEFT_OUT).all() and (found.verdict == LEFT_OUT).all()
    assert (found.halvings == -1).all() and (found.limit > 0).all()


def test_the_tables_name_what_is_wrong(cheap):
    assert tables.wrong_list(cheap.isel(case=[0], step=[0])).startswith("None")
    wrong = cheap.isel(case=[0], model=[0], step=[0]).copy(deep=True)
    wrong.verdict[:] = UNSEEN
    assert "handout's case, 5 cosines: unseen" in tables.wrong_list(wrong)
    assert "| handout's case | snapped" in tables.default_table(cheap)
    assert tables.step_table(cheap).count("\n") == 5


def test_every_verdict_has_colour_and_words():
    assert tuple(LOOKS) == VERDICTS


@pytest.mark.parametrize(
    ("error", "shown"), [(0.0, "0"), (np.inf, "∞"), (9e-4, "−3"), (1e-3, "−3"), (0.5, "0")]
)
def test_exponents_are_rounded_up(error, shown):
    assert exponent(error) == shown
