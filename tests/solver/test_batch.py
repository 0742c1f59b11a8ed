"""A batch of devices against each device alone: the same bits, whatever is asked."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.beam.equilibria import static_threshold
from snapmap.device import Beam, Device, batch
from snapmap.solver.adaptive import choose_model
from snapmap.solver.cells import to_cells
from snapmap.solver.settings import SNAP, Settings

MODELS = {
    "handout": {"name": "handout"},
    "elements": {"name": "elements", "elements": 10, "modes": 4},
    "cosines": {"name": "cosines", "modes": 3},
    "auto": {"name": "auto"},
}


@pytest.fixture(scope="module")
def devices():
    """Devices at random, of which some have a hard contact and some a damped beam."""
    draw, found = np.random.default_rng(11), []
    for contact in (40.0, np.inf, 150.0, np.inf, 60.0):
        thickness = draw.uniform(1.5, 2.5)
        beam = Beam(
            span=draw.uniform(400, 800),
            rise=thickness * draw.uniform(2.6, 7.0),
            thickness=thickness,
            depth=draw.uniform(15, 30),
            youngs_modulus=draw.uniform(1.3e5, 1.7e5),
            density=2.33e-3,
            damping=draw.choice([0.0, 4e-4]),
        )
        mass, spring = 10 ** draw.uniform(3.3, 4.3), draw.uniform(2, 12)
        found.append(Device(beam, mass, spring, contact, gravity=9.81e-6))
    return found


@pytest.mark.parametrize("name", MODELS)
def test_a_batch_is_each_of_its_devices(devices, name):
    if name == "handout":  # its modes depend on the contact
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


@pytest.mark.parametrize("model", ["cosines", "auto"])
@pytest.mark.parametrize(
    ("key", "values", "f0"),
    [
        ("thickness", [1.8, 2.1], 9000.0),
        ("contact", [40.0, np.inf], 9000.0),
        ("mass", [6e3, 1e4], 5800.0),
    ],
)
def test_thresholds_of_a_batch_are_those_of_each_device(handout, model, key, values, f0):
    asked = {"f0": [1500.0, f0], "C": [0.025, 25.0], "horizon": 300.0, "model": model}
    together = snapmap.threshold(handout, **asked, **{key: values})
    for value in values:
        if key == "thickness":
            device = dataclasses.replace(
                handout, beam=dataclasses.replace(handout.beam, **{key: value})
            )
        else:
            device = dataclasses.replace(handout, **{key: value})
        alone = snapmap.threshold(device, **asked)
        mine = together.sel({key: value})
        for name in alone:
            own, whole = alone[name].values, mine[name].values
            if "island" in alone[name].dims:
                most = own.shape[-1]
                assert np.isnan(whole[..., most:]).all()
                whole = whole[..., :most]
            np.testing.assert_array_equal(whole, own, err_msg=name)
    assert (together.islands > 0).any()
