"""A batch of devices against each device alone: the same bits, whatever is asked."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import batch
from snapmap.solver.adaptive import choose_model
from snapmap.solver.cells import to_cells
from snapmap.solver.settings import SNAP, Settings
from studies.random_devices import draw_widest_device

MODELS = {
    "all modes": {"name": "elements"},
    "elements": {"name": "elements", "elements": 10, "modes": 5},
    "cosines": {"name": "cosines", "modes": 3},
    "auto": {"name": "auto"},
}


@pytest.fixture(scope="module")
def devices():
    """Devices at random: uneven, free to tilt, with stops, a hard contact or a damped beam."""
    draw = np.random.default_rng(11)
    drawn = [draw_widest_device(draw) for _ in range(5)]
    damped = [dataclasses.replace(one.beam, damping=4e-4 * (i % 2)) for i, one in enumerate(drawn)]
    return [dataclasses.replace(one, beam=own) for one, own in zip(drawn, damped, strict=True)]


@pytest.mark.parametrize(
    "name",
    [pytest.param("all modes", marks=pytest.mark.long), "elements", "cosines", "auto"],
)
def test_a_batch_is_each_of_its_devices(devices, name):
    if name in ("elements", "auto"):  # with the tilting modes of free ones kernels take a minute
        devices = [device for device in devices if not device.beam.free]
    if name == "all modes":  # its modes depend on the contact
        devices = [device for device in devices if np.isfinite(device.contact)]
    together, settings = choose_model(batch(devices), MODELS[name]), Settings(horizon=200.0)
    shares = np.linspace(0.7, 2.0, 14)
    N = np.multiply.outer([static_threshold(device) for device in devices], shares)
    f0 = np.array([[700.0], [3000.0]])
    number = np.arange(len(devices))[:, np.newaxis]
    rows = np.tile(N, (2, 1)), np.repeat(f0, len(devices), axis=0), np.tile(number, (2, 1))
    mixed = together.follow(to_cells(together.device, rows[2], *rows[:2], 5.0, 200.0), settings)
    snapped = np.isfinite(mixed.t_snap)
    assert 0.2 < snapped.mean() < 0.9
    for i, device in enumerate(devices):
        alone = choose_model(device, MODELS[name])
        for one, picked in zip(alone.levels, together.pick(i).levels, strict=True):
            assert one.device == picked.device
            for values, others in zip(
                (*one.modal, *one.barrier), (*picked.modal, *picked.barrier), strict=True
            ):
                np.testing.assert_array_equal(values, others)
            own_cells = to_cells(device, 0, N[i], f0, 5.0, 200.0)
            dt = (m.steps.of(own_cells, SNAP) for m in (one, picked))
            np.testing.assert_array_equal(*dt)
        single = alone.follow(to_cells(device, 0, N[[i, i]], f0, 5.0, 200.0), settings)
        for whole, own in zip(mixed, single, strict=True):
            if own is not None:
                np.testing.assert_array_equal(whole[[i, i + len(devices)]], own)


@pytest.mark.parametrize(
    ("model", "contacts"), [("cosines", [40.0, 60.0]), ("auto", [40.0, np.inf])]
)
def test_thresholds_of_a_batch_are_those_of_each_device(handout, model, contacts):
    asked = {"f0": [1500.0, 9000.0], "C": [0.025, 25.0], "horizon": 300.0, "model": model}
    together = snapmap.threshold(handout, **asked, contact=contacts)
    for contact in contacts:
        alone = snapmap.threshold(dataclasses.replace(handout, contact=contact), **asked)
        mine = together.sel(contact=contact)
        for name in alone:
            own, whole = alone[name].values, mine[name].values
            if "island" in alone[name].dims:
                most = own.shape[-1]
                assert np.isnan(whole[..., most:]).all()
                whole = whole[..., :most]
            np.testing.assert_array_equal(whole, own, err_msg=name)
    assert (together.islands > 0).any()
