"""The cases of a plan: ways to simulate, each family of them changing one thing."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from snapmap.device import Device
from snapmap.solver.models import Model, build_model
from snapmap.solver.settings import Settings

from .plans import Plan

FAMILIES = (
    "elements_consistent",
    "elements_hrz",
    "cosines",
    "cosines_uncorrected",
    "step",
    "penalty",
    "horizon",
)
MODELS = FAMILIES[:4]
"""Families of models: of one device, followed alike, and so to be ranked."""
CONVERGED, HARD = "converged", "converged, hard contact"


class Case(NamedTuple):
    """A way to simulate, and the name of what its answer is held against."""

    name: str
    family: str
    model: Model
    settings: Settings
    against: str


def list_cases(device: Device, settings: Settings, plan: Plan) -> Iterator[Case]:
    """Every case of a plan; each family changes one thing and leaves the others alone."""
    for name, family, model in (*_elements(device, plan), *_cosines(device, plan)):
        yield Case(name, family, model, settings, CONVERGED)
    for step in plan.steps:
        model = build_model(device, "handout", step=step)
        yield Case(f"step {step:g}", "step", model, settings, f"step {plan.steps[0]:g}")
    for factor in (*plan.penalties, math.inf) if math.isfinite(device.contact) else ():
        stiff = replace(device, contact=factor * device.contact)
        model = build_model(stiff, "cosines", modes=plan.cosines[-1])
        yield Case(f"contact x {factor:g}", "penalty", model, settings, HARD)
    longest, model = f"horizon x {plan.horizons[-1]:g}", build_model(device, "handout")
    for factor in plan.horizons:
        longer = settings._replace(horizon=factor * settings.horizon)
        yield Case(f"horizon x {factor:g}", "horizon", model, longer, longest)


def _elements(device, plan):
    for mass in ("consistent", "hrz"):
        for n in plan.elements:
            name, options = f"{n} elements, {mass}", {"elements": n, "mass_matrix": mass}
            if 2 * n - 1 > plan.most_modes:
                name, options["modes"] = f"{name}, {plan.most_modes} modes", plan.most_modes
            yield name, f"elements_{mass}", build_model(device, "elements", **options)


def _cosines(device, plan):
    models = {n: build_model(device, "cosines", modes=n) for n in plan.cosines}
    for n, model in models.items():
        yield f"{n} cosines", "cosines", model
    # Without it, hard contact would have no finite stiffness.
    for n, model in models.items() if math.isfinite(device.contact) else ():
        plain = replace(model, modal=model.modal._replace(residual=0.0))
        yield f"{n} cosines, uncorrected", "cosines_uncorrected", plain
