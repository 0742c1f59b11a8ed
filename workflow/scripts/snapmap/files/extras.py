"""What to install where an optional package is missing."""

from collections.abc import Iterator
from contextlib import contextmanager

EXTRAS = {
    "dask": "workflow",
    "pint": "config",
    "plotly": "page",
    "psutil": "workflow",
    "pydantic": "config",
    "snakemake": "workflow",
    "tqdm": "workflow",
    "yaml": "config",
}
"""Extra of pyproject.toml by the name that its package is imported by."""


@contextmanager
def needing(what: str) -> Iterator[None]:
    """Raise ImportError, one line that names the extra, where one of its packages is missing."""
    try:
        yield
    except ModuleNotFoundError as missing:
        package = (missing.name or "").partition(".")[0]
        if package not in EXTRAS:
            raise
        remedy = f"pip install 'snapmap[{EXTRAS[package]}]'"
        raise ImportError(f"{what} needs {package}: {remedy}", name=package) from None
