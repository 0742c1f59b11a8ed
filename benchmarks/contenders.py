"""Who is compared: the package's models, and their peers as far as they are installed."""

from importlib.util import find_spec

from peers import by_heyoka, by_scipy
from workload import Follow

from snapmap.device import Device
from snapmap.models import Model, build_model

REFERENCE, HANDOUT, FOUR = "reference (plain loop)", "handout (9 modes)", "cosines, 4 modes"
MODELS = {
    REFERENCE: ("reference", {}),
    HANDOUT: ("handout", {}),
    "cosines, 3 modes": ("cosines", {"modes": 3}),
    FOUR: ("cosines", {"modes": 4}),
    "cosines, 6 modes": ("cosines", {"modes": 6}),
}
WIDTHS = {"heyoka, 1 lane": 1, "heyoka, 8 lanes": 8}
METHODS = {"SciPy DOP853": "DOP853", "SciPy LSODA": "LSODA"}


def build(device: Device, name: str) -> Model:
    """Build a model of the comparison by its name there."""
    model, options = MODELS[name]
    return build_model(device, model, **options)


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
    return {name: by_scipy(device, modal, method) for name, method in METHODS.items()}
