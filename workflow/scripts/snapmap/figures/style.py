"""What every figure for print shares: style sheet, sizes, legend, and how it is saved."""

import json
import textwrap
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib.style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.legend import Legend

from ..io.atomic import replacing
from ..pulse import VERSED_SINE
from ..shocks import MAKERS

COLUMN, PAGE = 56, 130
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


def is_alone(ax: Axes) -> bool:
    """Whether axes are the only ones of their figure or subfigure."""
    return ax.get_figure().axes == [ax]


def labelled(axes: Iterable[Axes]) -> list[Artist]:
    """What is labelled on some axes, each label once."""
    pairs = [zip(*reversed(ax.get_legend_handles_labels()), strict=True) for ax in axes]
    return list({label: key for each in pairs for label, key in each}.values())


def legend(
    where: Axes | FigureBase, keys: Iterable[Artist], title: str = "", ncols: int = 4
) -> Legend:
    """Put a legend below a figure, or axes, in as many columns as have room.

    That of axes alone on their figure is the figure's.
    """
    if isinstance(where, Axes) and is_alone(where):
        where = where.get_figure()
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}
    if isinstance(where, FigureBase):
        place = {"loc": "outside lower center"}
    keys = list(keys)
    while True:
        made = where.legend(handles=keys, title=title, ncols=ncols, **place)
        if ncols == 1 or made.get_window_extent().width <= where.bbox.width:
            return made
        made.remove()
        ncols -= 1


def fit(figure: Figure, ratio: float) -> None:
    """Make a figure so high that its axes, all alike, are `ratio` times as high as wide."""
    rows = figure.axes[0].get_subplotspec().get_gridspec().nrows
    for _ in range(2):  # as what stands beside them grows with them, a little
        figure.draw_without_rendering()
        width, height = figure.axes[0].get_position().size * figure.get_size_inches()
        figure.set_figheight(figure.get_figheight() + rows * (ratio * width - height))


def save(figure: Figure, stem: str | Path, attributes: Mapping[str, str]) -> None:
    """Write a figure as PDF and PNG, without dates, each whole or not at all.

    stem: the path without its ending
    attributes: of the dataset drawn; title, code_version and config go into the files' metadata
    """
    # What a screen shows first.
    for kind, keys in reversed(METADATA.items()):
        metadata = {key: attributes[name] for key, name in keys.items() if name in attributes}
        if kind == "pdf":
            metadata["CreationDate"] = None
        with replacing(f"{stem}.{kind}") as temporary:
            figure.savefig(temporary, format=kind, metadata=metadata)


def case(attributes: Mapping[str, str], width: int = PAGE) -> str:
    """Which model was followed for how long, from a dataset's attributes; empty without them.

    With it goes whether the beam is guided, as then its labels hold for one that cannot tilt.
    width: most signs in a line; COLUMN below one column
    """
    if "config" not in attributes:
        return ""
    config = json.loads(attributes["config"])
    pulse = config.get("pulse", {})
    made = next((key for key in MAKERS if key in pulse), VERSED_SINE)
    shape = pulse.get("file", pulse.get("shape", made))
    words = [literal(shape)] if isinstance(shape, str) else []
    words += ["along −z"] if pulse.get("direction") == "-z" else []
    horizon = config["sweep"]["horizon"].replace("us", "µs")
    words += [*guides(config), model_words(config), f"followed {horizon} beyond the pulse"]
    return textwrap.fill(", ".join(words), width)


def literal(text: str) -> str:
    """A user's text, drawn as it is: a dollar begins no formula."""
    return text.replace("$", r"\$")


def model_words(config: Mapping) -> str:
    """The name of a config's model, and what it is made of: `handout model (5 Hermite ...)`."""
    model = config["model"]
    cosines = model.get("cosines", model.get("modes", 5))
    kept = model.get("modes", cosines)
    if model["name"] == "auto":
        parts = ["as many cosines as each cell needs"]
    elif model["name"] == "cosines":
        parts = [f"{cosines} cosines" if kept == cosines else f"{kept} modes of {cosines} cosines"]
    else:
        parts = [f"{model.get('elements', 5)} Hermite elements on half the beam"]
        if "modes" in model:
            parts.append(f"{kept} modes")
        elif '"contact": "hard"' not in json.dumps(config):
            parts.append("all modes")
        parts += ["plain loop"] * (model["name"] == "reference")
    return f"{model['name']} model ({', '.join(parts)})"


def guides(config: Mapping) -> list[str]:
    """Whether the beams of a config are guided or free, in words; none if they differ."""
    devices = config.get("devices", {"": config["device"]} if "device" in config else {})
    free = {device["beam"].get("guide") == "free" for device in devices.values()}
    words = {False: "guided beam", True: "beam free to tilt"}
    return [words[free.pop()]] if len(free) == 1 else []
