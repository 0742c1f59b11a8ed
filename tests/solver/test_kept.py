"""What is kept of a device: as if it were made anew, and never that of another device."""

from dataclasses import replace

import numpy as np
from varied import varied

import snapmap
from snapmap import Study
from snapmap.device.device import batch
from snapmap.solver.adaptive import choose_survey
from snapmap.solver.kept import FEW, forget, kept
from snapmap.solver.options import Auto, Cosines


def test_models_are_kept_by_the_values_of_the_device_the_model_and_the_start(handout):
    device, auto = batch([handout]), Auto()
    made = choose_survey(device, auto)
    assert choose_survey(batch([replace(handout)]), auto) is made
    devices = batch([varied(handout, gap=0.01)]), batch([varied(handout, rise=7.01)])
    others = [choose_survey(other, auto) for other in (*devices, batch([handout, handout]))]
    others += [choose_survey(device, model) for model in (Auto(tolerance=1e-4), Cosines(modes=3))]
    others.append(choose_survey(device, auto, "second"))
    assert len({id(survey) for survey in [made, *others]}) == 7
    assert others[0].decides.device.gap == 0.01 and made.decides.device.gap == 0.0


def test_a_number_is_not_taken_for_a_batch_of_one_and_nothing_is_kept_of_many_or_of_laws(handout):
    model, calls = Auto(), []

    def make():
        calls.append(0)
        return len(calls)

    one = batch([handout])
    seen = [kept(make, device, model, "x") for device in (handout, one, handout, one)]
    assert seen == [1, 2, 1, 2]
    assert kept(make, one, model, "x", 3.0) == 3 and kept(make, one, model, "y") == 4
    many = batch([handout] * (FEW + 1))
    assert kept(make, many, model, "x") != kept(make, many, model, "x")
    laws = Cosines(laws={"damping": lambda C, velocity, place: C * velocity})
    assert kept(make, one, laws, "x") != kept(make, one, laws, "x")
    forget()
    assert kept(make, one, model, "x") == len(calls)


def test_the_limit_of_short_pulses_is_that_of_a_first_call(handout):
    asked = {"model": "3 cosines"}
    first = snapmap.threshold(Study(handout, **asked), [2000.0], [25.0, 200.0])
    again = snapmap.threshold(Study(handout, **asked), [3000.0], [25.0, 200.0])
    alone = snapmap.threshold(Study(handout, pulse="half sine", **asked), [3000.0], [200.0])
    forget()
    anew = snapmap.threshold(Study(handout, **asked), [3000.0], [25.0, 200.0])
    assert again.identical(anew)
    np.testing.assert_array_equal(first.velocity_change, anew.velocity_change)
    np.testing.assert_array_equal(alone.velocity_change, anew.velocity_change.sel(C=[200.0]))
