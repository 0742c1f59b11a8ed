"""Scatter: distributions and samples, and what cannot scatter."""

import numpy as np
import pytest
from scipy import stats
from small_studies import cases_of
from varied import varied

from snapmap.device.samples import CUT, Groups, Plan, Samples, Scatters, Tolerances
from snapmap.values.arguments import Reading
from snapmap.values.kinds import kind_of

CASES = cases_of(__file__)
SCATTERS = {0.05: 0.05, "5 %": 0.1, ("normal", "5 %"): 0.1, ("uniform", 0.3): 0.3 / np.sqrt(3)}
SCATTERS |= {("lognormal", "30 %"): 0.6, ("truncated", 0.1): 0.1 * stats.truncnorm.std(-CUT, CUT)}


@pytest.mark.parametrize("scatter", SCATTERS)
def test_samples_have_the_moments_of_their_distribution(handout, scatter):
    law = dict([scatter]) if isinstance(scatter, tuple) else scatter
    plan = Plan(handout, kind_of(Scatters).take({"thickness": law}))
    values = plan.values(plan.points(4096, seed=3)[0])["thickness"]
    assert values.mean() == pytest.approx(2.0, rel=2e-3)
    assert values.std() == pytest.approx(SCATTERS[scatter], rel=2e-2)


def test_samples_are_seeded_grow_and_move_together(handout):
    scatters = {"thickness": 0.05, "rise": "2 %", "depth": {"uniform": 0.1}}
    scatters |= {"residual_stress": 5.0, "C": {"lognormal": "5 %"}}
    plan = Plan(handout, kind_of(Scatters).take(scatters), together=[["thickness", "depth"]])
    assert plan.names == ["thickness+depth", "rise", "residual_stress", "C"]
    few, many = plan.points(100, 7), plan.points(1000, 7)
    np.testing.assert_array_equal(few, many[:, :100])
    assert (plan.points(100, 8) != few).all()
    values = plan.values(many[0])
    assert stats.spearmanr(values["thickness"], values["depth"])[0] == pytest.approx(1)
    assert abs(stats.spearmanr(values["thickness"], values["rise"])[0]) < 0.05
    assert abs(stats.spearmanr(many[0, :, 0], many[1, :, 0])[0]) < 0.05


@pytest.mark.parametrize(("law", "nominal", "values"), CASES["exact"])
def test_a_standard_deviation_aside_lie_the_values_of_a_law_which_is_written_as_it_is_read(
    law, nominal, values
):
    scatter = kind_of(Scatters).take({"residual_stress": law})["residual_stress"]
    u = stats.norm.cdf([-1, 0, 1])
    np.testing.assert_allclose(scatter.values(nominal, u), values, rtol=2e-7)
    assert kind_of(Scatters).take({"rise": scatter.written})["rise"] == scatter


def test_a_truncated_law_ends_at_two_deviations_and_counts_are_powers_of_two():
    scatter = kind_of(Scatters).take({"N": {"truncated": "1 %"}})["N"]
    assert scatter.values(1.0, np.array([0.0, 0.5, 1.0])).tolist() == [0.98, 1.0, 1.02]
    asked = [(1000, None), (2_000_000, None), (5000, 7), (6, 7)]
    made = [Tolerances({}, samples=samples, index_samples=some) for samples, some in asked]
    assert [each.power for each in made] == [512, 1024, 4, 4]
    assert [made[1].followed(cells) for cells in (1, 1000, 10**5)] == [10**6, 1000, 64]
    assert made[3].followed(10**5) == 6 and Tolerances({}) == ({}, (), 1000, None, 1)
    assert kind_of(Samples).need == "a whole number from 2 to 100000"


@pytest.mark.parametrize(("values", "scatters", "line"), CASES["wrong"])
def test_what_cannot_scatter_is_refused_with_its_reason(handout, values, scatters, line):
    scatters = {key: kind_of(Scatters).take({key: law})[key] for key, law in scatters.items()}
    together = [["span", "rise"], ["span"]] if "span" in scatters else ()
    with pytest.raises(ValueError, match=rf"^{line}"):
        Plan(varied(handout, **values), scatters, together).values(np.array([[1e-9]]))


def test_groups_are_lists_of_names():
    for wrong in ("ab", ["ab"], [["a"], 3], [[1]]):
        with pytest.raises(ValueError, match=r"is not a list of groups of names, as \[\[span"):
            kind_of(Groups).take(wrong)


@pytest.mark.parametrize(("written", "key", "law", "line"), CASES["written"])
def test_a_width_is_a_share_or_a_value_above_0_or_of_a_known_law(written, key, law, line):
    with pytest.raises(ValueError, match=line):
        kind_of(Scatters).convert({key: law}, Reading(written))
