"""What made a file: the versions of code and packages, and the config; the same on every host."""

import hashlib
import json
import math
import platform
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .. import __version__
from ..device.device import ALONE, KINDS, Device
from ..values.records import told

KEYWORDS = "bistable beam, snap-through, MEMS, shock sensor"
PACKAGES = ("numpy", "numba", "xarray", "netCDF4", "dask", "matplotlib", "snakemake")
OF_NUMBERS, OF_DRAWING = ("numpy", "numba", "scipy"), ("matplotlib", "plotly")
"""Packages named in each file; those of which numbers and figures are made again by others."""
_PACKAGE = Path(__file__).parents[1]
_CODE = ".csv", ".html", ".js", ".mplstyle", ".py", ".svg"


def _draws(path):
    """Tell whether a file of the package draws, and makes no numbers."""
    is_of_figures = path.relative_to(_PACKAGE).parts[0] == "figures"
    return is_of_figures or path.name == "figure.py" or path.suffix not in (".py", ".csv")


_FILES = [
    path
    for path in _PACKAGE.rglob("*")
    if path.suffix in _CODE
    and "pipeline" not in path.relative_to(_PACKAGE).parts
    and path != _PACKAGE / "workflow" / "command.py"
]
DRAWS = [path for path in _FILES if _draws(path)]
NUMBERS = [path for path in _FILES if not _draws(path)]
"""The files of the code that draw, and those that make numbers."""


def provenance(document: Mapping) -> dict[str, str]:
    """Give the attributes of every product: its config, and the versions of code and packages."""
    return {
        "source": "numerical simulation",
        # No date: the same input gives the same file.
        "history": f"computed by snapmap {code_version()}",
        "keywords": KEYWORDS,
        "config": json.dumps(document, default=str),  # laws from Python by their names
        "code_version": code_version(),
        **versions(),
    }


def versions() -> dict[str, str]:
    """Give the attributes of every file that tell the versions of packages and Python."""
    return {"packages": _packages(PACKAGES), "python": platform.python_version()}


def config_of(attributes: Mapping[str, str]) -> dict:
    """Give the config in the attributes of a product; empty without one."""
    return json.loads(attributes.get("config", "{}"))


@cache
def _packages(names):
    """Give names and versions of those packages that are installed."""
    installed = []
    for package in names:
        with suppress(PackageNotFoundError):
            installed.append(f"{package} {version(package)}")
    return " ".join(installed)


def device_sections(device: Device | Mapping[str, Device]) -> dict:
    """Give the section `device` or `devices` of a config, with units."""
    if isinstance(device, Mapping):
        return {"devices": {name: _section(single) for name, single in device.items()}}
    return {"device": _section(device)}


def _section(device):
    beam = _written(told(device.beam))
    values = told(device)
    if device.temperature == device.reference_temperature:
        del values["temperature"]
    if device.force:
        del values["gravity"]
    left_out = ("beam", *(ALONE if device.is_alone else ()))
    values = _written({key: value for key, value in values.items() if key not in left_out})
    return {"beam": beam} | ({"mass": "none"} if device.is_alone else {}) | values


def _written(values):
    """Write values of a device as a config has them, with units."""
    texts = {
        key: "hard" if value == math.inf else f"{float(value)!r} {KINDS[key].unit}".strip()
        for key, value in values.items()
        if key in KINDS
    }
    return texts | ({"free": True} if values.get("free") else {})


@cache
def code_version() -> str:
    """Give the version, such as `0.3.0+1a2b3c4.dirty sources 5d6e7f8a9b0c`; git adds the commit."""
    commit = _git("describe", "--always", "--dirty=.dirty", "--abbrev=7")
    number = f"{__version__}+{commit}" if commit else __version__
    return f"{number} sources {code_hash(*NUMBERS, *DRAWS)}"


def code_hash(*paths: Path) -> str:
    """Give 12 hex digits of the SHA-256 of code and data: files, and all files below folders.

    It is the same wherever they lie.
    """
    files = {file for path in paths for file in (path, *path.rglob("*")) if file.suffix in _CODE}
    digest = hashlib.sha256()
    for name, text in sorted((file.name, file.read_bytes()) for file in files):
        digest.update(name.encode() + b"\0" + text)
    return digest.hexdigest()[:12]


def hash_numbers(script: str | Path) -> dict[str, str]:
    """Hash what makes numbers by its name in messages: code, the script of its jobs, and versions.

    Other versions of Python or of packages may give other last bits.
    """
    code = code_hash(*NUMBERS, Path(script))
    made_by = f"{code} {_packages(OF_NUMBERS)} {platform.python_version()}"
    return {"the code that makes numbers": hashlib.sha256(made_by.encode()).hexdigest()[:12]}


def hash_drawing(script: str | Path) -> dict[str, str]:
    """Hash what draws by its name in messages: code, the script of its jobs, and packages."""
    made_by = f"{code_hash(*DRAWS, Path(script))} {_packages(OF_DRAWING)}"
    return {"the code that draws": hashlib.sha256(made_by.encode()).hexdigest()[:12]}


def config_hash(document: Mapping) -> str:
    """Give 12 hex digits of the SHA-256 of a config's values, as sorted JSON."""
    text = json.dumps(document, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@cache
def code_date() -> str:
    """Give the day of the commit, such as `2026-11-28`; empty without git."""
    return _git("log", "-1", "--format=%cs")


def _git(*words):
    """Ask git about the clone; empty without git."""
    # With the folders named, git accepts another user's clone, and takes no folder around it.
    clone = _PACKAGE.parents[2]
    command = ["git", f"--git-dir={clone}/.git", f"--work-tree={clone}", *words]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return run.stdout.strip()


if __name__ == "__main__":  # for a report of a fault
    print(f"snapmap {code_version()}, Python {platform.python_version()}, {platform.platform()}")
    print(_packages(PACKAGES))
