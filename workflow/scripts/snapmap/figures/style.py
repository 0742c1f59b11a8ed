"""What every figure for print shares: the style sheet, the sizes, and how it is saved."""

import os
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib.style
from matplotlib.figure import Figure

SHEET = Path(__file__).with_name("paper.mplstyle")
# Which metadata of each format holds which attribute of a dataset.
METADATA = {
    "pdf": {"Title": "title", "Creator": "code_version", "Subject": "config"},
    "png": {"Title": "title", "Software": "code_version", "Comment": "config"},
}


def paper() -> AbstractContextManager:
    """Context in which a figure is made, drawn and saved, whatever the user's own settings."""
    return matplotlib.style.context(SHEET, after_reset=True)


def single_column(height: float) -> Figure:
    """Make an empty figure as wide as one column of a journal, 3.4 in; height: in."""
    return Figure(figsize=(3.4, height))


def double_column(height: float) -> Figure:
    """Make an empty figure as wide as two columns of a journal, 7.0 in; height: in."""
    return Figure(figsize=(7.0, height))


def save(
    figure: Figure, path_pdf: str | Path, path_png: str | Path, attributes: Mapping[str, str]
) -> None:
    """Write a figure as PDF and PNG, without dates, each whole or not at all.

    attributes: of the dataset drawn; title, code_version and config go into the files' metadata
    """
    for kind, path in {"pdf": path_pdf, "png": path_png}.items():
        temporary = f"{path}.part"
        figure.savefig(temporary, format=kind, metadata=_metadata(kind, attributes))
        os.replace(temporary, path)


def damping(C: float) -> str:
    """Typeset the damping coefficient of the mass; C: uN us/um."""
    return f"$C$ = {C:g} µN µs µm$^{{-1}}$"


def _metadata(kind, attributes):
    undated = {"CreationDate": None} if kind == "pdf" else {}
    keys = METADATA[kind].items()
    return undated | {key: attributes[name] for key, name in keys if name in attributes}
