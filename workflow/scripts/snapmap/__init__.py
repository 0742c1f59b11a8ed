"""Snap maps of a bistable beam under shock. `__init__.pyi` lists the functions and classes."""

import re as _re
from importlib import import_module as _import_module
from pathlib import Path as _Path

from .applications import FOLDERS as _FOLDERS
from .files.extras import needing as _needing

__version__ = "0.4.0"

_PLACE = _re.compile(r"^from \.([\w.]+) import (\w+) as \w+$", _re.M)
_HOME = {
    name: module
    for module, name in _PLACE.findall(_Path(__file__).with_suffix(".pyi").read_text("utf-8"))
    if not module.startswith("applications.") or module.split(".")[1] in _FOLDERS
}
__all__ = sorted(_HOME)


def __dir__():
    return [*__all__, "__version__"]


def __getattr__(name):
    # Imports wait for the first use, as a solver job must not pay for xarray.
    if name in _HOME:
        with _needing(f"{__name__}.{name}"):
            from .public import checked

            named = getattr(_import_module(f".{_HOME[name]}", __name__), name)
        return globals().setdefault(name, named if isinstance(named, type) else checked(named))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
