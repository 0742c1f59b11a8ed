"""What every figure for print shares: the style sheet, the sizes, and how it is saved."""

import json
import textwrap
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib.style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation, blended_transform_factory

from ..io.atomic import replacing
from ..pulse import VERSED_SINE
from ..trains import MAKERS

COLUMN, PAGE = 50, 130
"""Signs in a line over one column, and over two."""
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


def notebook_axes() -> Axes:
    """Axes on a figure of their own that a notebook shows."""
    # For notebooks alone: no rule pays for its import.
    import matplotlib.pyplot as plt

    return plt.figure(figsize=(5, 5), layout="constrained").subplots()


def save(figure: Figure, stem: str | Path, attributes: Mapping[str, str]) -> None:
    """Write a figure as PDF and PNG, without dates, each whole or not at all.

    stem: the path without its ending
    attributes: of the dataset drawn; title, code_version and config go into the files' metadata
    """
    # What a screen shows first.
    for kind in ("png", "pdf"):
        with replacing(f"{stem}.{kind}") as temporary:
            figure.savefig(temporary, format=kind, metadata=_metadata(kind, attributes))


def case(attributes: Mapping[str, str], width: int = PAGE) -> str:
    """Which model was followed for how long, from a dataset's attributes; empty without them.

    With it goes whether the beam is guided, as then its labels hold for one that cannot tilt.
    width: most signs in a line; COLUMN for a title over one column
    """
    if "config" not in attributes:
        return ""
    config = json.loads(attributes["config"])
    horizon = config["sweep"]["horizon"].replace("us", "µs")
    pulse = config.get("pulse", {})
    made = next((key for key in MAKERS if key in pulse), VERSED_SINE)
    shape, direction = pulse.get("file", pulse.get("shape", made)), pulse.get("direction")
    words = [literal(shape)] if isinstance(shape, str) else []
    words += [f"along {direction}"] if direction == "-z" else []
    words += guides(config)
    words += [model_words(config), f"followed {horizon} beyond the pulse"]
    return textwrap.fill(", ".join(words), width)


def literal(text: str) -> str:
    """A user's text, drawn as it is: a dollar begins no formula."""
    return text.replace("$", r"\$")


def model_words(config: Mapping) -> str:
    """The name of a config's model, and what it is made of: `handout model (5 Hermite ...)`."""
    model = config["model"]
    return f"{model['name']} model ({', '.join(_parts_of_model(model, config))})"


def _parts_of_model(model, config):
    if model["name"] == "auto":
        return ["as many cosines as each cell needs"]
    if model["name"] == "cosines":
        cosines = model.get("cosines", model.get("modes", 5))
        kept = model.get("modes", cosines)
        return [f"{cosines} cosines" if kept == cosines else f"{kept} modes of {cosines} cosines"]
    parts = [f"{model.get('elements', 5)} Hermite elements on half the beam"]
    if "modes" in model:
        parts.append(f"{model['modes']} modes")
    elif '"contact": "hard"' not in json.dumps(config):
        parts.append("all modes")
    return [*parts, "plain loop"] if model["name"] == "reference" else parts


def guides(config: Mapping) -> list[str]:
    """Whether the beams of a config are guided or free, in words; none if they differ."""
    devices = config.get("devices", {"": config["device"]} if "device" in config else {})
    free = {device["beam"].get("guide") == "free" for device in devices.values()}
    words = {False: "guided beam", True: "beam free to tilt"}
    return [words[free.pop()]] if len(free) == 1 else []


def legend_below(
    ax: Axes,
    keys: Iterable[Artist],
    title: str,
    ncols: int,
    below: float = 30,
    of_all: bool = False,
) -> None:
    """Put a legend below the axis' own labels; below: pt.

    ncols: at most, as many as have room
    of_all: whether it is that of all axes, and stands in the middle of the figure as for axes alone
    """
    figure, keys = ax.get_figure(), list(keys)
    down = ScaledTranslation(0, -below / 72, figure.dpi_scale_trans)
    alone = of_all or len(figure.axes) == 1
    middle, box = (figure.transFigure, figure.bbox) if alone else (ax.transAxes, ax.bbox)
    at = blended_transform_factory(middle, ax.transAxes) + down
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0), "bbox_transform": at}
    for columns in range(ncols, 0, -1):
        legend = ax.legend(handles=keys, title=title, ncols=columns, **place)
        if legend.get_window_extent().width <= box.width:
            break


def _metadata(kind, attributes):
    undated = {"CreationDate": None} if kind == "pdf" else {}
    keys = METADATA[kind].items()
    return undated | {key: attributes[name] for key, name in keys if name in attributes}
