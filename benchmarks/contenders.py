"""Who is compared: the package's models, and their peers as far as they are installed."""

from importlib.util import find_spec

from kernel import HANDOUT, KERNELS
from peers import by_heyoka, by_scipy
from workload import Follow

from snapmap.device import Device
from snapmap.solver.models import Model, build_model
from studies.few import few

REFERENCE = "reference (plain loop)"
MODELS = {REFERENCE: {"name": "reference"}, **KERNELS}
FEWEST = 3
"""Models of a small run."""
WIDTHS = {"heyoka, 1 lane": 1, "heyoka, 8 lanes": 8}
METHODS = {"SciPy DOP853": "DOP853", "SciPy LSODA": "LSODA"}


def build(device: Device, name: str) -> Model:
    """Build a model of the comparison by its name there."""
    return build_model(device, **MODELS[name])


def heyokas(device: Device) -> dict[str, Follow]:
    """heyoka on the handout's 9 modes, one cell at a time and several."""
    if not find_spec("heyoka"):
        return {}
    modal = build(device, HANDOUT).modal
    return {name: by_heyoka(device, modal, width) for name, width in WIDTHS.items()}


def scipys(device: Device) -> dict[str, Follow]:
    """SciPy on the handout's 9 modes, by an explicit method and one for stiff systems."""
    if not find_spec("scipy"):
        return {}
    modal = build(device, HANDOUT).modal
    return {name: by_scipy(device, modal, method) for name, method in few(METHODS).items()}
