"""What a plan counts, requests and names, by its own words."""

import math

import numpy as np
import pytest
import yaml
from small_studies import TINY, changed

from snapmap.applications.whole import load_config
from snapmap.workflow.plan import amounts, core_seconds, make_plan

DOCUMENT = yaml.safe_load(TINY)


@pytest.mark.parametrize(("points", "caution"), [(8, 20), (24_000, 20), (24_000, 1e6)])
def test_a_job_requests_what_its_start_and_its_cells_take(monkeypatch, points, caution):
    monkeypatch.setattr("snapmap.workflow.plan.CAUTION", caution)
    plan = make_plan(load_config(changed(DOCUMENT, sweep__N__points=points)))
    assert len(plan.slabs) == (1 if points == 8 else 2)
    cells, seconds = 4 * points / len(plan.slabs), plan.seconds / len(plan.slabs)
    request = int(1000 + 5e-4 * cells), math.ceil(2 + caution * seconds / 60)
    np.testing.assert_allclose(plan.requests, [request] * len(plan.slabs), rtol=1e-4)


def test_the_time_of_a_study_is_that_of_its_jobs_figures_and_runs():
    """A slab and three products; statics, a history, a damage boundary and a page to look at."""
    study = load_config(DOCUMENT)
    plan = make_plan(study)
    assert amounts(study) == {"cells": 32, "thresholds": 4, "histories": 1, "verdicts": 0}
    runs = plan.seconds / 32 * (32 + 700 * 4 + 700)
    assert core_seconds(study, plan) == pytest.approx(2.5 * 4 + 0.5 * 4 + runs, rel=1e-12)
