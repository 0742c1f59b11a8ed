"""The hard cases: by default nothing goes wrong unseen."""

import pytest

from snapmap import Reference
from studies.stability import verdicts as V
from studies.stability.cases import CASES, MODELS
from studies.stability.measure import measure

SHORT = (
    *("handout's case", "five times as strong", "contact 4e5 N/m", "hard contact"),
    *("1 % below the threshold", "at the threshold", "1 % above the threshold", "f0 = 100 kHz"),
    *("N = 0", "N = 1e-6", "N = -1000", "N = 1e6", "Q 0.01 % above its limit"),
)


@pytest.fixture(scope="module")
def cheap(handout):
    """The short cases with the cheapest model of the kernel and the plain loop, at a few steps."""
    cases = [case for case in CASES if case.name in SHORT]
    models = {"3 cosines": MODELS["3 cosines"], "reference": Reference(elements=2)}
    return measure(handout, cases, models, steps=(0.4, 1.0, 1.5))


def test_nothing_goes_wrong_unseen(cheap):
    """Nor fails at the default step: the halved ones are enough for every one of these cells."""
    assert cheap.sizes["case"] == len(SHORT)
    assert (cheap.verdict.drop_sel(case="hard contact") != V.UNSEEN).all()
    beyond = cheap.sel(model="reference", step=1.5).drop_sel(case=["N = 0", "hard contact"])
    assert (beyond.verdict == V.CAUGHT).all()
    assert not cheap.energy_error.sel(case="N = 0").any()
    soft = cheap.drop_sel(case="hard contact")  # refused by the reference
    assert (soft.default_verdict < V.CAUGHT).all()
    assert (soft.default_energy_error <= 1e-3).all() and (soft.halvings >= 0).all()
    refused = cheap.sel(case="hard contact", model="reference")
    assert (refused.verdict == V.REFUSED).all() and refused.default_verdict == V.REFUSED


def test_stiff_contact_sets_the_limit_of_the_reference_alone(cheap):
    stiff, soft = (cheap.limit.sel(case=case) for case in ("contact 4e5 N/m", "handout's case"))
    assert stiff.sel(model="reference") < 0.2 * soft.sel(model="reference")
    assert stiff.sel(model="3 cosines") == soft.sel(model="3 cosines")
