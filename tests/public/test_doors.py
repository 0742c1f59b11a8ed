"""Doors of the package: what a mask hides is no number, and callers' settings change nothing."""

import numpy as np
import pytest
import xarray as xr

import snapmap

ROWS = {"N": [900.0], "f0": [1500.0], "C": [25.0]}


def masked(values):
    return np.ma.array(values, mask=[False, *[True] * (len(values) - 1)])


@pytest.fixture
def study(handout):
    return snapmap.Study(handout, model="cosines")


@pytest.mark.parametrize("key", ROWS)
@pytest.mark.parametrize("of", [float, int])
def test_what_a_mask_hides_on_an_axis_is_refused(study, key, of):
    hidden = masked(np.array([900, 1200], of))
    with pytest.raises(ValueError, match=rf"^{key}: "):
        snapmap.sweep(study, **ROWS | {key: hidden})
    with pytest.raises(ValueError, match="thickness"):
        snapmap.sweep(study, **ROWS, axes={"thickness": masked([2.0, 2.1])})


def test_hidden_samples_of_a_record_and_hidden_shots_are_refused(handout):
    time, acceleration = np.arange(5.0), np.array([0.0, 1.0, 2.0, 1.0, 0.0])
    for record in ((masked(time), acceleration), (time, masked(acceleration))):
        with pytest.raises(ValueError, match="number"):
            snapmap.sampled(*record)
    shots = {"N": [800, 900, 1000], "tripped": [0, 0, 1], "duration": [1000.0] * 3}
    for key, values in shots.items():
        with pytest.raises(ValueError, match="shots, row 2"):
            hidden = shots | {key: masked(values)}
            snapmap.calibrate(handout, hidden, {"thickness": (1.7, 2.3)}, C=25.0)


def test_settings_of_the_callers_numpy_and_xarray_change_nothing(study):
    def results():
        found = snapmap.sweep(study, **ROWS), snapmap.threshold(study, [1500.0], [25.0])
        return [*found, snapmap.statics(study.device)]

    before = results()
    with np.errstate(all="raise"), xr.set_options(keep_attrs=True, arithmetic_join="exact"):
        after = results()
    for one, other in zip(before, after, strict=True):
        xr.testing.assert_identical(one, other)
