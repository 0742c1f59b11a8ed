"""Snap maps of a bistable beam under shock. `__all__` lists the public functions and classes."""

from importlib import import_module

from .applications import public_names
from .files.extras import needing

__version__ = "0.3.0"

_HOME = {
    "Beam": "device.curved_beam",
    "Device": "device.device",
    "Pulse": "pulse.pulse",
    "load_device": "config.devices",
    "open_cube": "sweeps.collect",
    "plot_outcome": "figures.maps",
    "read_pulse": "pulse.recorded",
    "reference": "solver.laws",
    "sampled": "pulse.pulse",
    "sweep": "sweeps.cube",
    "threshold": "thresholds.surface",
    **public_names(),
}
__all__ = sorted(_HOME)


def __dir__():
    return [*__all__, "__version__"]


def __getattr__(name):
    # Imports wait for the first use, as a solver job must not pay for xarray.
    if name in _HOME:
        with needing(f"{__name__}.{name}"):
            from .public import checked

            named = getattr(import_module(f".{_HOME[name]}", __name__), name)
        return globals().setdefault(name, named if isinstance(named, type) else checked(named))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
