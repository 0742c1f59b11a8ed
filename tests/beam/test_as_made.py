"""Residual stress, a gap, and beams that are free to tilt."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from conserving_loop import assert_followed
from scipy.optimize import brentq, minimize
from small_studies import THREE_COSINES

import snapmap
from snapmap.beam.basis import Basis
from snapmap.beam.cosines import antisymmetric_loads, buckling_shapes, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import find_barrier, static_threshold
from snapmap.beam.modal import reduce_to_modes, settled
from snapmap.config.doubts import doubts, tilting
from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError
from snapmap.device import batch
from snapmap.pulse import make_pulse
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from studies.proofs import FREE, leavers

CHEAP = {"model": "cosines", "modes": 3}
STRESSES = (-40.0, -5.0, 5.0, 60.0)


def vary(device, **values):
    own = {key: values.pop(key) for key in [*values] if hasattr(device, key)}
    return replace(device, beam=replace(device.beam, **values), **own)


def one_mode_equilibria(beam):
    """c = w(L/2)/rise of all equilibria along the first cosine: roots of the cubic, by numpy."""
    first_load = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    arch = 0.75 * beam.bistability**2
    push = -beam.residual_stress * beam.area / first_load
    roots = np.roots([arch, 0, 1 - arch - push, -1])
    return np.sort(roots[abs(roots.imag) < 1e-9].real)


@pytest.mark.parametrize("stress", STRESSES)
@pytest.mark.parametrize("thickness", [1.4, 2.0, 3.0])
def test_shapes_at_rest_are_the_roots_of_the_cubic(handout, stress, thickness):
    made = replace(handout.beam, thickness=thickness)
    if stress > made.most_stress:
        pytest.skip("not bistable")
    beam = replace(made, residual_stress=stress)
    low, *_, high = one_mode_equilibria(beam)
    assert beam.height == pytest.approx(high * beam.rise, rel=1e-12)
    assert beam.second_equilibrium == pytest.approx(low * beam.rise, rel=1e-12)
    assert replace(made, residual_stress=0.0).height == made.rise


def test_stresses_at_which_things_change(handout):
    """The flat beam buckles at 5.483 MPa; state 2 goes at 69.45, and stays if free from -2.419."""
    beam = handout.beam
    load = 4 * np.pi**2 * beam.bending_stiffness / beam.span**2
    assert beam.buckling_stress == pytest.approx(load / beam.area)
    assert beam.buckling_stress == pytest.approx(5.483, rel=1e-4)

    def force(stress):
        """The axial force in state 2 over the first load."""
        return 1 - 1 / one_mode_equilibria(replace(beam, residual_stress=stress))[0]

    at_end = force(beam.most_stress * (1 - 1e-9))
    assert at_end == pytest.approx(4, rel=1e-7)
    assert beam.most_stress == pytest.approx(69.45, rel=1e-4)
    tilt = (antisymmetric_loads(1)[0] / (2 * np.pi)) ** 2
    stays = brentq(lambda stress: force(stress) - tilt, -5, 0)
    assert stays == pytest.approx(-2.419, rel=1e-3)
    for stress, expected in ((1.001 * stays, True), (0.999 * stays, False)):
        assert replace(beam, residual_stress=stress).stays_if_free == expected
    with pytest.raises(ValueError, match="imperfection: 1 um is of a free beam"):
        replace(beam, imperfection=1.0)
    with pytest.raises(ValueError, match=r"of 70 MPa leave no .* below 69.453 MPa"):
        replace(beam, residual_stress=70.0).require_second_shape()


def test_antisymmetric_shapes_are_clamped_and_orthogonal():
    mu = antisymmetric_loads(6)
    np.testing.assert_allclose(np.tan(mu / 2) / (mu / 2), 1, rtol=1e-12)
    y = (np.arange(200_000) + 0.5) / 200_000 - 0.5
    shapes = np.sin(np.outer(mu, y)) / np.sin(mu / 2)[:, np.newaxis] - 2 * y
    slopes = mu[:, np.newaxis] * np.cos(np.outer(mu, y)) / np.sin(mu / 2)[:, np.newaxis] - 2
    basis = buckling_shapes(6)
    np.testing.assert_allclose(shapes @ shapes.T / y.size, basis.mass[6:, 6:], atol=1e-8)
    np.testing.assert_allclose(slopes @ slopes.T / y.size, basis.geometric[6:, 6:], atol=2e-5)
    assert abs(shapes[:, [0, -1]]).max() < 1e-4 and abs(slopes[:, [0, -1]]).max() < 2e-2
    assert abs(basis.tilt[6] * shapes[0]).max() == pytest.approx(1, rel=1e-8)


def test_elements_have_the_antisymmetric_frequencies_and_shape():
    fine, exact = hermite_elements(20, free=True), buckling_shapes(20)
    made = snapmap.load_device("config/config.yaml").beam
    low = [reduce_to_modes(made, basis, 8).stiffness for basis in (fine, exact)]
    np.testing.assert_allclose(*low, rtol=4e-4)
    energy = [basis.tilt @ basis.bending @ basis.tilt for basis in (fine, exact)]
    assert energy[0] == pytest.approx(energy[1], rel=1e-4)


@pytest.mark.parametrize("basis", [symmetric_cosines(4), hermite_elements(4)])
@pytest.mark.parametrize("stress", STRESSES)
def test_at_rest_no_force_is_left(handout, basis: Basis, stress):
    beam = replace(handout.beam, residual_stress=stress)
    rest, made = settled(basis, beam), basis.scaled_to(beam)
    u = beam.rise * (rest.start - basis.start)
    stretch = u @ made.geometric @ (u + 2 * made.start)
    tension = stress * beam.area + beam.axial_stiffness * stretch
    force = made.bending @ u + tension * made.geometric @ (u + made.start)
    assert abs(force).max() < 1e-9 * abs(made.bending @ made.start).max()
    assert basis.midpoint @ rest.start * beam.rise == pytest.approx(beam.height, rel=2e-3)


def test_a_free_beam_with_stress_starts_from_its_own_midpoint(handout):
    """Where its energy is least, by a search; that of a guided one is elsewhere."""
    stressed = replace(handout.beam, residual_stress=-8.0, imperfection=2.0, free=1.0)
    made = buckling_shapes(8).scaled_to(stressed)

    def energy(q):
        u = q - made.start
        stretch = q @ made.geometric @ q - made.start @ made.geometric @ made.start
        axial = stressed.residual_stress * stressed.area * stretch / 2
        return u @ made.bending @ u / 2 + axial + stressed.axial_stiffness * stretch**2 / 4

    found = minimize(energy, made.start, method="BFGS", options={"gtol": 1e-9})
    rest = made.midpoint @ found.x
    assert rest == pytest.approx(10.3461, abs=1e-4) and abs(rest - stressed.height) > 0.02
    assert find_barrier(stressed, buckling_shapes(8)).first == pytest.approx(rest, abs=1e-5)
    run = snapmap.simulate(
        replace(handout, beam=stressed), 1, 1500, 25, model="cosines", modes=3, horizon=0
    )
    assert run.w_mid[0].item() == run.z_mass[0].item() == pytest.approx(rest, abs=1e-4)


def pass_by_search(beam, basis):
    """The largest of the least energies for each midpoint, on the way to the second shape."""
    modal = reduce_to_modes(beam, basis)

    def energy(p):
        stretch = p @ modal.geometric @ p + 2 * p @ modal.slope_start
        return p @ (modal.stiffness * p) / 2 + modal.axial * stretch**2 / 4

    def least(way, near):
        on_way = {"type": "eq", "fun": lambda p: modal.midpoint @ p - way}
        return minimize(energy, near, constraints=on_way, method="SLSQP", tol=1e-11)

    whole = beam.second_equilibrium - beam.height
    best, p = 0.0, np.zeros(modal.load.size)
    # An antisymmetric nudge, as the search itself would stay on the symmetric path.
    nudge = 1e-3 * np.abs(apply_tilt(basis, modal)).max()
    for way in np.linspace(0.05, 1.0, 96) * whole:
        found = least(way, p + nudge * apply_tilt(basis, modal))
        p, best = found.x, max(best, found.fun)
    return best


def apply_tilt(basis, modal):
    """Modes without a midpoint, each by one."""
    return np.where(abs(modal.midpoint) < 1e-9 * abs(modal.midpoint).max(), 1.0, 0.3)


@pytest.mark.parametrize(
    ("values", "free"),
    [
        ({"residual_stress": -10.0}, False),
        ({"residual_stress": 20.0}, False),
        ({"thickness": 1.2, "free": 1.0, "imperfection": 0.004}, True),
        ({"residual_stress": -20.0, "free": 1.0, "imperfection": 0.02}, True),
    ],
)
def test_the_barrier_is_the_lowest_pass(handout, values, free):
    beam = replace(handout.beam, **values)
    basis = buckling_shapes(3) if free else symmetric_cosines(3)
    barrier = find_barrier(beam, basis)
    assert barrier.energy == pytest.approx(pass_by_search(beam, basis), rel=5e-3)
    finer = [find_barrier(beam, hermite_elements(n, free=free)).energy for n in (6, 12)]
    many = find_barrier(beam, buckling_shapes(12) if free else symmetric_cosines(12)).energy
    assert abs(finer[1] - many) < abs(finer[0] - many) < 1e-2 * many
    assert finer[1] == pytest.approx(many, rel=1e-3)


def test_a_single_mode_has_the_pass_of_the_cubic(handout):
    beam = replace(handout.beam, residual_stress=12.0)
    _, middle, start = one_mode_equilibria(beam)
    barrier = find_barrier(beam, symmetric_cosines(1))
    assert barrier.midpoint == pytest.approx((middle - start) * beam.rise, rel=1e-9)
    assert barrier.energy > find_barrier(beam, symmetric_cosines(2)).energy > 0


def test_tilting_lowers_the_barrier_and_may_end_it(handout):
    guided = replace(handout.beam, thickness=1.2)
    free = replace(guided, free=1.0, imperfection=1e-6)
    basis, energies = buckling_shapes(4), []
    for imperfection in (1e-6, 0.003, 0.005):
        energies.append(find_barrier(replace(free, imperfection=imperfection), basis).energy)
    whole = find_barrier(guided, symmetric_cosines(4)).energy
    assert whole > energies[0] > energies[1] > energies[2] > 0
    w2 = guided.second_equilibrium
    assert find_barrier(free, basis).second == pytest.approx(w2, rel=1e-9)
    assert find_barrier(replace(free, thickness=2.0), basis).energy == 0
    assert find_barrier(replace(free, imperfection=2.0), basis).energy == 0


def test_a_batch_is_each_of_its_devices(handout):
    devices = [
        handout,
        vary(handout, residual_stress=-8.0),
        vary(handout, gap=1.0),
        vary(handout, free=1.0, imperfection=0.02),
        vary(handout, residual_stress=12.0, gap=0.4),
    ]
    model = build_model(batch(devices), "cosines", modes=3)
    N, f0 = np.linspace(800, 1300, 12), 1500.0
    settings = Settings(300.0)
    number = np.arange(len(devices))[:, np.newaxis]
    mixed = model.follow(to_cells(model.device, number, N, f0, 5.0, 300.0), settings)
    for i, device in enumerate(devices):
        alone = build_model(device, "cosines", modes=3)
        seen = alone.follow(to_cells(device, 0, N[np.newaxis], f0, 5.0, 300.0), settings)
        for whole, own in zip(mixed[:6], seen[:6], strict=True):
            np.testing.assert_array_equal(whole[[i]], own)


@pytest.mark.parametrize(
    "values",
    [
        {"residual_stress": -10.0},
        {"gap": 0.7},
        {"free": 1.0, "imperfection": 0.05},
        {"residual_stress": 8.0, "gap": 0.3, "free": 1.0, "imperfection": 0.01},
    ],
)
def test_the_kernel_follows_the_plain_loop(handout, values):
    device = vary(handout, **values)
    model = build_model(device, "cosines", modes=3)
    assert_followed(model, make_pulse(), 900.0, 5000.0, 5.0, 0.2, 1200)
    quiet = snapmap.simulate(device, 0, 1500, 5.0, "reference", elements=2, horizon=100.0)
    assert np.ptp(quiet.w_mid.values) == 0 and np.ptp(quiet.z_mass.values) == 0


@pytest.mark.parametrize("contact", [40.0, np.inf])
@pytest.mark.parametrize(
    "values", [{"gap": 0.7}, {"residual_stress": -10.0, "free": 1.0, "imperfection": 0.05}]
)
def test_energy_closes(handout, contact, values):
    device = vary(handout, **values, contact=contact)
    cube = snapmap.sweep(device, [700, 1000, 1500], [800, 4000], [0.0, 25.0], **CHEAP)
    assert cube.energy_error.max() < 1e-10


def test_across_a_gap_the_mass_swings_alone(handout):
    device = vary(handout, gap=60.0)
    run = snapmap.simulate(device, 500, 2000, 0.0, horizon=200.0, **CHEAP)
    assert not run.contact_force.any()
    omega, f0 = np.sqrt(device.spring / device.mass), 2000e-6
    t, forcing, half = run.time.values, 2 * np.pi * f0, -500 * device.gravity / 2
    in_pulse = t < 1 / f0
    swing = (np.cos(forcing * t) - np.cos(omega * t)) / (omega**2 - forcing**2)
    exact = half * ((1 - np.cos(omega * t)) / omega**2 - swing)
    rest = device.beam.rise + 60.0
    np.testing.assert_allclose(run.z_mass.values[in_pulse] - rest, exact[in_pulse], atol=2e-3)


@pytest.mark.parametrize(
    "values",
    [
        {"residual_stress": 20.0},
        {"gap": 1.5},
        {"free": 1.0, "imperfection": 0.05},
    ],
)
def test_slow_pulses_snap_at_the_static_threshold(handout, values):
    device = vary(handout, **values)
    found = snapmap.threshold(device, [12.0], [400.0], **CHEAP)
    assert found.N_first.item() == pytest.approx(static_threshold(device), rel=4e-3)


def test_thresholds_of_both_bases_meet(handout):
    """Trial figures of the handout's device at 1500 Hz, C = 0.025, good to 0.1 %; in fine steps."""
    known = [({"residual_stress": 5.0}, 963.5), ({"gap": 1.0}, 1021.0)]
    for values, N in known:
        device = vary(handout, **values)
        cosines = snapmap.threshold(device, [1500.0], [0.025], model="cosines", modes=5, step=0.5)
        elements = snapmap.threshold(
            device, [1500.0], [0.025], model="elements", elements=5, step=0.5
        )
        assert cosines.N_first.item() == pytest.approx(N, rel=1e-3)
        assert elements.N_first.item() == pytest.approx(cosines.N_first.item(), rel=3e-3)


def test_a_free_beam_snaps_earlier_fast_and_later_slow(handout):
    free = vary(handout, free=1.0, imperfection=0.01)
    found = snapmap.threshold(free, [200.0, 1500.0], [0.025], **CHEAP).N_first.squeeze()
    np.testing.assert_allclose(found, [1064, 848], rtol=1e-2)


@pytest.mark.long
def test_proofs_hold_with_tilt(handout):
    device = vary(handout, **FREE)
    model, settings = build_model(device, "cosines", modes=3), Settings()
    f0, N = (values.ravel() for values in np.meshgrid(np.geomspace(300, 8e3, 6), [500, 900, 1500]))
    cells = to_cells(device, 0, N, f0, 25.0, settings.horizon)
    seen = model.follow_once(cells, settings)
    proven = np.flatnonzero(np.isfinite(seen.t_settled))
    assert proven.size > 9 and {1, 2} == set(seen.well[proven])
    for some in np.array_split(proven, 2):
        assert not leavers(model, cells.some(some), seen.t_settled[some], seen.well[some])


@pytest.fixture
def document():
    sweep = {"N": [800, 1200], "f0": ["1 kHz"], "C": ["25 uN*us/um"], "horizon": "300 us"}
    return yaml.safe_load(THREE_COSINES) | {"sweep": sweep}


def with_beam(document, **values):
    device = document["device"] | {"gap": "0.5 um"}
    return document | {"device": device | {"beam": device["beam"] | values}}


def test_a_config_says_how_the_beam_is_made(document):
    beam = {"residual_stress": "-11 MPa", "guide": "free", "imperfection": "10 nm"}
    study = load_config(with_beam(document, **beam))
    made = study.device.beam
    assert (made.residual_stress, made.free, made.imperfection) == (-11.0, 1.0, 0.01)
    assert study.device.gap == 0.5
    sweep = document["sweep"] | {"residual_stress": ["-5 MPa", "0 MPa", "5 MPa"]}
    assert next(iter(load_config(document | {"sweep": sweep}).axes)) == "residual_stress"


@pytest.mark.parametrize(
    ("beam", "wanted"),
    [
        (
            {"residual_stress": "80 MPa"},
            "device.beam: rise/thickness = 10 um/2 um = 5 and a stress of 80 MPa leave",
        ),
        (
            {"thickness": "22 um", "residual_stress": "-11 MPa"},
            "device.beam: rise/thickness = 10 um/22 um = 0.454545 and a stress of -11 MPa "
            "leave no second stable shape; it needs a stress below -1234.1 MPa",
        ),
        (
            {"thickness": "22 um", "residual_stress": "11 MPa"},
            "device.beam: rise/thickness = 10 um/22",
        ),
        ({"residual_stress": "5 um"}, "device.beam.residual_stress: '5 um' does not convert"),
        ({"guide": "loose"}, "device.beam.guide: 'loose' is not one of guided"),
        ({"imperfection": "1 um"}, "device.beam.imperfection: is of a free beam"),
        ({"guide": "free"}, "device.beam.imperfection: 0; a free beam without one never tilts"),
        ({"guide": "free", "imperfection": "-1 um"}, "device.beam.imperfection: '-1 um' is neg"),
    ],
)
def test_what_cannot_be_made_is_named_in_one_line(document, beam, wanted):
    with pytest.raises(ConfigError) as fault:
        load_config(with_beam(document, **beam))
    assert str(fault.value).startswith(wanted) and "\n" not in str(fault.value)


def test_a_study_says_for_which_beam_its_labels_hold(document, handout):
    (line,) = doubts(load_config(document))
    assert line.startswith("device: rise/thickness = 5: labels hold for a guided beam only")
    assert tilting(replace(handout.beam, thickness=1.7)) == ""
    assert tilting(replace(handout.beam, residual_stress=-5.0)) == ""
    assert "no stable second shape" in tilting(replace(handout.beam, free=1.0, imperfection=0.01))
    assert tilting(replace(handout.beam, **FREE)) == ""
