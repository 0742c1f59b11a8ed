"""What the errors are held against, what beats what, and what the report and its figure state."""

import dataclasses
import warnings

import numpy as np
import pytest
import xarray as xr

from snapmap.device import Beam, Device
from snapmap.figures import style
from snapmap.pulse import HANDOUT_SHOCK, sampled, shocks_from
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings
from studies.accuracy import figures
from studies.accuracy.budget import afford
from studies.accuracy.cases import CONVERGED, list_cases
from studies.accuracy.comparison import disagreement, pareto_front
from studies.accuracy.converged import FINE_STEP, converge, decided, gap
from studies.accuracy.dataset import summary
from studies.accuracy.measure import measure
from studies.accuracy.plans import PLANS as plans
from studies.accuracy.plans import Refinement
from studies.accuracy.probe import MOST_ROWS, Probe, list_own_rows, list_rows, make_probe

SNAP = Settings(300.0, "snap", False, threads=2)
REFINEMENT = Refinement((8, 6), (12, 6), (8, 6))
TINY = plans["quick"]._replace(
    elements=(3, 5),
    most_modes=9,
    cosines=(3,),
    penalties=(1,),
    converged=Refinement((8, 3)),
    hard=Refinement((5, 3)),
    side=4,
)


@pytest.fixture(scope="module")
def other():
    """A stiffer, flatter device."""
    beam = Beam(450.0, 6.5, 1.8, 30.0, 169e3, 2.33e-3)
    return Device(beam, mass=4e3, spring=9.0, contact=150.0, gravity=9.81e-6)


@pytest.fixture(scope="module")
def found(handout):
    """A report of few cases."""
    axes = axes_of([0.025, 200.0], [500.0, 1500.0], [800.0, 1200.0])
    return measure(handout, axes, SNAP, TINY)


def axes_of(C, f0, N):
    return {"C": C, "f0": f0, "N": N}


def probe_of(f0, N):
    """Thresholds at C = 25 of a few f0, all near the mean of N, and a map."""
    rows, axes = to_rows(0, f0, 25.0), {"C": np.array([25.0]), "f0": np.array(f0), "N": np.array(N)}
    near = np.full(len(f0), np.mean(N))
    return Probe(rows, near, np.ones(len(f0), bool), axes, HANDOUT_SHOCK)


def drawn(found):
    """Both figures of a report, as axes."""
    with style.paper(), warnings.catch_warnings(action="error"):
        ax = figures.draw_accuracy(style.double_column(height=3.6).subplots(), found)
        axes = figures.draw_convergence(style.double_column(height=3.2).subplots(1, 2), found)
        ax.figure.canvas.draw()
        axes[0].figure.canvas.draw()
    return ax, *axes


def test_the_front_is_what_no_other_beats_in_both():
    time = np.array([1.0, 2.0, 3.0, 4.0, 2.0, 1.0, np.nan, 0.5])
    error = np.array([5.0, 3.0, 3.0, 1.0, 4.0, 5.0, 0.1, np.nan])
    front = [True, True, False, True, False, True, False, False]
    assert pareto_front(time, error).tolist() == front


def test_labels_disagree_where_one_snaps_and_the_other_does_not():
    f0 = np.array([1e3, 2e3])
    reference = np.array([[[900.0, 1100.0, np.nan], [400.0, 600.0, np.nan]]])
    t_snap = np.array([[[np.nan, 1200.0, np.nan], [410.0, np.nan, 5.0]]])
    assert disagreement(t_snap, reference, f0) == (3 / 6, 1 / 2)
    assert np.isnan(disagreement(t_snap, 0 * t_snap + np.nan, f0)[1])


def test_what_is_asked_lies_within_the_sweep(handout):
    axes = axes_of([200.0, 1.0, 5.0], np.geomspace(100, 1e4, 5), [0.0, 500.0, 900.0])
    rows = list_rows(axes, HANDOUT_SHOCK)
    assert rows.C.tolist() == 3 * [1.0] + 3 * [200.0] and rows.device.tolist() == 6 * [0]
    assert rows.f0[:3] == pytest.approx([100 * 10**0.5, 1000, 1000 * 10**0.5])
    probe = make_probe(handout, axes, SNAP, TINY._replace(side=3), HANDOUT_SHOCK)
    C, f0, N = (probe.axes[key] for key in ("C", "f0", "N"))
    assert C.tolist() == [1.0, 200.0] and f0 == pytest.approx([100, 1000, 1e4])
    assert N.tolist() == [0.0, 450.0, 900.0]


def test_every_pulse_of_the_study_is_asked():
    axes = axes_of([1.0, 200.0], np.geomspace(100, 1e4, 5), [900.0])
    shocks = shocks_from(["half sine", "sawtooth"], "both")
    rows = list_rows(axes, shocks)
    assert set(rows.pulse) == set(range(4)) and rows.f0.size == MOST_ROWS
    assert set(list_rows(axes, shocks_from("sawtooth")).pulse) == {0}


def test_own_rows_are_slow_and_damped(handout):
    rows = list_own_rows(handout, 400.0, HANDOUT_SHOCK)
    own = handout.own_frequency / (2 * np.pi) * 1e6
    assert rows.f0 == pytest.approx([0.2 * own, 0.4 * own])
    assert pytest.approx(0.2 * np.sqrt(handout.spring * handout.mass)) == rows.C


def test_rows_of_the_device_itself_stand_in_for_those_that_are_not_well_posed(handout):
    """Far above the device's own frequency, without damping, no threshold is clean."""
    axes = axes_of([0.0], [5800.0], [1000.0])
    probe = make_probe(handout, axes, SNAP, TINY, HANDOUT_SHOCK)
    ragged = probe.rows.f0 == 5800.0
    assert not probe.clean[ragged].any() and probe.clean[~ragged].all() and (~ragged).sum() == 3


@pytest.mark.parametrize("spring", [5.5, 1e-2])
@pytest.mark.parametrize("slowest", [1.0, 1000.0])
def test_what_is_measured_is_affordable(handout, spring, slowest):
    """However slow the pulses, long the horizon, and many the shocks."""
    device = dataclasses.replace(handout, spring=spring)
    axes = axes_of([0.0, 1.0], np.geomspace(slowest, 1e4, 5), [1000.0])
    shocks, long = shocks_from(["half sine", "sawtooth"], "both"), SNAP._replace(horizon=1e6)
    found = afford(device, axes, long, plans["full"], shocks)
    again = afford(device, found.axes, found.settings, found.plan, shocks)
    assert found.settings.horizon < 1e6 and len(found.left_out) == 2 + (slowest == 1.0)
    assert again.left_out == () and again.plan == found.plan
    easy = afford(device, axes_of([1.0], [1e4], [1.0]), SNAP, plans["quick"], HANDOUT_SHOCK)
    assert easy.left_out == () and easy.settings == SNAP


@pytest.mark.parametrize("hard", [False, True])
def test_two_discretisations_agree_within_their_own_errors(handout, other, hard):
    for device, f0, N in [(handout, [457.7, 1500.0], [1000.0]), (other, [1000.0], [3000.0])]:
        device = dataclasses.replace(device, contact=np.inf) if hard else device
        run = converge(device, probe_of(f0, N), SNAP, REFINEMENT)
        assert gap(run) < 1 and decided(run).all()
        known = run.error[0] + run.other_error[0]
        assert (known < 1e-3 * run.answer.values[0]).all()


def test_disagreement_beyond_the_own_errors_is_seen(handout):
    run = converge(handout, probe_of([1500.0], [900.0, 1100.0]), SNAP, Refinement((4, 3)))
    assert np.isnan(gap(run))
    off = run._replace(other=run.answer.values + 3 * run.error, other_error=run.error)
    assert gap(off) == pytest.approx(1.5)
    assert gap(off._replace(error=run.answer.values)) == 0.0


def test_elements_converge_with_order_four(handout):
    """Against Richardson's value of the two finest of three meshes, each twice as fine."""

    def threshold(elements):
        model = build_model(handout, "elements", elements=elements, modes=8, step=0.3)
        rows = to_rows(0, [457.7, 1500.0], 25.0)
        return lowest_snap(model, rows, (850.0, 1100.0), SNAP, tolerance=1e-9)

    coarse, middle, fine = (threshold(elements) for elements in (5, 10, 20))
    order = np.log2((coarse - middle) / (middle - fine))
    assert (np.abs(order - 4) < 0.3).all()


def test_every_case_has_a_name_and_something_to_be_held_against(handout):
    hard = dataclasses.replace(handout, contact=np.inf)
    for device, plan in [(handout, plans["full"]), (hard, plans["full"]), (hard, plans["quick"])]:
        cases = list(list_cases(device, SNAP, plan))
        names = [case.name for case in cases]
        assert len(set(names)) == len(names)
        assert {case.against for case in cases} <= {*names, CONVERGED, "converged, hard contact"}
        assert {figures.HANDOUT, figures.HANDOUT_STEP} <= set(names)
        families = {case.family for case in cases}
        assert ("penalty" in families) == ("cosines_uncorrected" in families) == (device is handout)


def test_the_report_states_the_largest_sources(found):
    worst = found.threshold_worst
    assert worst.sel(model="contact x 1") == pytest.approx(0.1, abs=0.02)
    assert worst.sel(model="5 elements, consistent") == pytest.approx(0.0016, abs=3e-4)
    assert worst.sel(model="3 cosines") < 1e-3 < worst.sel(model="3 cosines, uncorrected")
    assert worst.sel(model="step 0.8") < 3e-5
    assert worst.sel(model="step 0.4") == 0 and np.isnan(found.discretisations_gap)
    assert (found.time_per_simulation > 0).all() and found.on_front.sel(model="3 cosines") == 1


def test_the_figure_marks_the_front_and_the_handouts_setting(found):
    ax, *_ = drawn(found)
    lines = {line.get_label(): line.get_xydata() for line in ax.lines}
    case = found.sel(model=figures.HANDOUT)
    at = [case.time_per_simulation.item(), case.threshold_worst.item()]
    assert lines["the handout's setting"].tolist() == [at]
    (front,) = (points for label, points in lines.items() if label.startswith("Pareto"))
    assert len(front) == found.on_front.sum()
    sources = figures.other_sources(found)
    assert sources["contact 40 N/m, not hard"] == found.threshold_worst.sel(model="contact x 1")
    low, high = ax.get_ylim()
    assert all(low < error < high for error in sources.values())


def test_other_shocks_have_other_thresholds(handout):
    """The study's own pulses are measured, and named."""
    axes = axes_of([25.0], [1000.0], [800.0, 1200.0])
    shocks = shocks_from("half sine", "both")
    both = measure(handout, axes, SNAP, TINY, shocks)
    assert both["shape"].values.tolist() == 2 * ["half sine"]
    assert both.direction.values.tolist() == ["+z", "-z"]
    ours = both.converged_threshold.isel(reference=0).values
    model = build_model(handout, "cosines", modes=8, step=FINE_STEP)
    rows = to_rows(0, 1000.0, 25.0, [0, 1], shocks.pulses)
    again = lowest_snap(model, rows, (ours / 1.01, ours * 1.01), SNAP, 1e-6, 0.005)
    assert again == pytest.approx(ours, rel=3e-6) and ours[1] > 2 * ours[0]


def test_without_thresholds_labels_are_judged(handout):
    """Pulses that press nothing snap nothing: no threshold, and yet no empty picture."""
    pulls = shocks_from(sampled(np.array([0.0, 1.0, 2.0]), np.array([0.0, -1e-6, 0.0])))
    found = measure(handout, axes_of([200.0], [1e5], [1.0, 2.0]), SNAP, TINY, pulls)
    assert not found.threshold_decided.any() and found.judged_by == "label_error"
    assert (found.on_front == 1).any() and "labels" in summary(found)
    ax, number, step = drawn(found)
    assert "no threshold is well posed" in ax.figure.legends[0].get_title().get_text()
    for one in (ax, number, step):
        points = np.concatenate([line.get_xydata() for line in one.lines])
        assert points.size and np.isfinite(points).all()
        low, high = one.get_ylim()
        assert not ((low < one.get_yticks()) & (one.get_yticks() < 0)).any() and low < 0 < high


def make_accuracy():
    """Errors of 3 and 6 elements of order 4, of cosines, and of steps of order 2."""
    families = {
        "elements_consistent": {"3 elements, consistent": 1.6e-2, "6 elements, consistent": 1e-3},
        "elements_hrz": {"3 elements, hrz": 2e-2},
        "cosines": {"3 cosines": 1e-3, "6 cosines": 1e-4},
        "cosines_uncorrected": {"3 cosines, uncorrected": 8e-3, "6 cosines, uncorrected": 1e-3},
        "step": {"step 0.1": 0.0, "step 0.4": 1e-5, "step 0.8": 4e-5},
    }
    names = [name for cases in families.values() for name in cases]
    codes = [i for i, cases in enumerate(families.values()) for _ in cases]
    worst = [error for cases in families.values() for error in cases.values()]
    one = ("reference", "row")
    variables = {
        "threshold_worst": ("model", worst),
        "converged_threshold": (one, [[1000.0, 1000.0]]),
        "converged_threshold_error": (one, [[0.02, 5.0]]),
        "threshold_decided": (one, [[1, 0]]),
    }
    family = ("model", codes, {"flag_meanings": " ".join(families)})
    attributes = {"judged_by": "threshold_worst"}
    return xr.Dataset(variables, {"model": names, "family": family}, attributes)


def converging():
    """The axes of the errors of `make_accuracy` over number and step."""
    axes = style.double_column(height=3.2).subplots(1, 2)
    return figures.draw_convergence(axes, make_accuracy())


def line(ax, label):
    return next(line for line in ax.lines if line.get_label().startswith(label))


def test_convergence_draws_the_errors_over_number_and_step():
    number, step = converging()
    assert line(number, "$n$ elements, consistent").get_xydata().tolist() == [
        [3, 1.6e-2],
        [6, 1e-3],
    ]
    assert line(number, "$n$ cosines, not").get_xydata().tolist() == [[3, 8e-3], [6, 1e-3]]
    assert line(step, "time step").get_xydata().tolist() == [[0.4, 1e-5], [0.8, 4e-5]]


def test_slopes_have_the_expected_orders():
    axes = converging()
    slopes = [line for ax in axes for line in ax.lines if line.get_linestyle() == ":"]
    ratios = [line.get_ydata()[1] / line.get_ydata()[0] for line in slopes]
    assert ratios == pytest.approx([2.0**-4, 2.0**-3, 2.0**2])


def test_what_the_converged_run_does_not_know_is_shaded():
    number, _ = converging()
    (shade,) = number.patches
    assert shade.get_y() + shade.get_height() == pytest.approx(2e-5)
