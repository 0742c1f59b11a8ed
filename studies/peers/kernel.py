"""snapmap's own loops: the kernel with proofs and without, and the handout's plain loop."""

from dataclasses import replace

from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Reference
from snapmap.solver.settings import Run

from .equations import Follow
from .scene import HORIZON, Scene

SETTINGS = Run(horizon=HORIZON, repeat=False).but(until="edge")


def by_kernel(scene: Scene, factor: float, proofs: bool = True) -> Follow:
    """Make a function that follows cells in the default steps of thresholds times a factor.

    proofs: whether a run also ends when its energy is below the barrier
    """
    model = scene.model if proofs else without_settling(scene.model)
    return followed(model.with_step(factor))


def by_plain_loop(scene: Scene) -> Follow:
    """Make a function that follows cells by the handout's scheme, over elements."""
    return followed(build_model(scene.device, Reference()))


def followed(model: Model) -> Follow:
    """Make a function that follows cells as thresholds do."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def without_settling(model: Model) -> Model:
    """Return the model with a barrier of 0, so that no cell settles before snap or horizon."""
    return replace(model, barrier=model.barrier._replace(energy=0.0, midpoint=0.0))
