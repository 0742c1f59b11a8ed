"""What a study amounts to, and about how long that takes one core, from a table of rates."""

from math import prod

from ..applications import gather, merge
from ..config.study import Config
from .plan import Plan

RUNS = {
    "cells": 1,
    "thresholds": 700,
    "thresholds of devices as made": 4,
    "verdicts": 1500,
    "histories": 700,
}
"""Runs that each takes, each as long as the mean run of a cell to its horizon."""
START, FIGURE = 2.5, 0.5
"""Core time of a job's start, and of a figure, s."""


def amounts(study: Config) -> dict[str, int]:
    """Count what a study computes, by the words of RUNS."""
    cells = prod(study.grid.shape)
    counts = {"cells": cells, "thresholds": cells // study.axes["N"].size}
    return counts | merge(lambda part: part.counts(study))


def core_seconds(study: Config, plan: Plan) -> float:
    """Estimate the core time of all jobs, s; runs that end early take less."""
    counts = amounts(study)
    runs = sum(RUNS[what] * count for what, count in counts.items())
    products = gather(lambda part: part.outputs(study))
    figures = sum(map(len, gather(lambda part: part.drawn(study)).values()))
    jobs = len(plan.slabs) + len(products)
    return START * jobs + FIGURE * figures + runs * plan.seconds / counts["cells"]
