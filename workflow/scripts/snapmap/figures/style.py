"""What every figure for print shares: the style sheet, the sizes, and how it is saved."""

import json
import textwrap
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from matplotlib.transforms import ScaledTranslation

from ..io.atomic import replacing

COLUMN = 56
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


def save(figure: Figure, stem: str | Path, attributes: Mapping[str, str]) -> None:
    """Write a figure as PDF and PNG, without dates, each whole or not at all.

    stem: the path without its ending
    attributes: of the dataset drawn; title, code_version and config go into the files' metadata
    """
    for kind in METADATA:
        with replacing(f"{stem}.{kind}") as temporary:
            figure.savefig(temporary, format=kind, metadata=_metadata(kind, attributes))


def case(attributes: Mapping[str, str], width: int = 200) -> str:
    """Which model was followed for how long, from a dataset's attributes; empty without them.

    With it goes whether the beam is guided, as then its labels hold for one that cannot tilt.
    width: most signs in a line; COLUMN for a title over one column
    """
    if "config" not in attributes:
        return ""
    config = json.loads(attributes["config"])
    horizon = config["sweep"]["horizon"].replace("us", "µs")
    pulse = config.get("pulse", {})
    shape, way = pulse.get("file", pulse.get("shape")), pulse.get("direction")
    words = [shape] if isinstance(shape, str) else []
    words += [f"along {way}"] if way == "-z" else []
    words += guides(config)
    words.append(f"{config['model']['name']} model, followed {horizon} beyond the pulse")
    return textwrap.fill(", ".join(words), width)


def guides(config: Mapping) -> list[str]:
    """Whether the beams of a config are guided or free, in words; none if they differ."""
    devices = config.get("devices", {"": config["device"]} if "device" in config else {})
    free = {device["beam"].get("guide") == "free" for device in devices.values()}
    words = {False: "guided beam", True: "beam free to tilt"}
    return [words[free.pop()]] if len(free) == 1 else []


def frequency_axis(ax: Axes) -> Axes:
    """Make x the frequency of the pulse, logarithmic, and add its duration above; returns that."""
    ax.set_xscale("log")
    ax.set_xlabel("pulse frequency $f_0$ (Hz)")
    top = ax.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
    top.set_xlabel("pulse duration $1/f_0$ (ms)")
    return top


def amplitude_axis(ax: Axes) -> None:
    """Make y the amplitude of the pulse, logarithmic, ticked 1, 2, 3, 5 in every decade."""
    ax.set_yscale("log")
    ax.set_ylabel("pulse amplitude $N$ (multiples of $g$)")
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter("")


def legend_below(ax: Axes, keys: Iterable[Artist], title: str, ncols: int) -> None:
    """Put a legend below the axis' own labels."""
    below = ax.transAxes + ScaledTranslation(0, -30 / 72, ax.figure.dpi_scale_trans)
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0), "bbox_transform": below}
    ax.legend(handles=list(keys), title=title, ncols=ncols, **place)


def _reciprocal(values):
    """1/f0 in ms from f0 in Hz, and back; matplotlib asks for it at 0, too."""
    with np.errstate(divide="ignore"):
        return 1e3 / np.asarray(values)


def _metadata(kind, attributes):
    undated = {"CreationDate": None} if kind == "pdf" else {}
    keys = METADATA[kind].items()
    return undated | {key: attributes[name] for key, name in keys if name in attributes}
