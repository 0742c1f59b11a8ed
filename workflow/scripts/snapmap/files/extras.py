"""The remedy for a missing optional package."""

from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "dask": "workflow",
    "pint": "config",
    "plotly": "page",
    "psutil": "workflow",
    "snakemake": "workflow",
    "tqdm": "workflow",
    "yaml": "config",
}
"""Extra of pyproject.toml that installs a package, by the name under which it is imported."""


@contextmanager
def needing(what: str) -> Iterator[None]:
    """Raise ImportError, one line that names the extra, if the block lacks an optional package."""
    try:
        yield
    except ModuleNotFoundError as missing:
        package = (missing.name or "").partition(".")[0]
        if package not in EXTRAS:
            raise
        remedy = f"pip install 'snapmap[{EXTRAS[package]}]'"
        raise ImportError(f"{what} needs {package}: {remedy}", name=package) from None
