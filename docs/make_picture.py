"""Draws docs/map.png from two of the configs:

PYTHONPATH=workflow/scripts ./run python docs/make_picture.py
"""

from pathlib import Path

import snapmap
from snapmap.config.study import load_study
from snapmap.config.yaml_file import read_document
from snapmap.figures import layout, maps, style

ROOT = Path(__file__).parents[1]
BESIDE = {
    "config.yaml": (25.0, "the handout's device, $C$ = 25 µN µs µm$^{-1}$"),
    "damped.yaml": (2.5, "with real damping: quality factors 94 (mass), 248 (beam)"),
}
"""The C of each config that is drawn, and what it is called."""


def main():
    with style.paper():
        figure = style.double_column(height=9)
        panels = [maps.Panel(cells(name, C)) for name, (C, _) in BESIDE.items()]
        axes = maps.draw_maps(figure, panels, "f0", "N")
        for ax, (_, words) in zip(axes.flat, BESIDE.values(), strict=True):
            ax.set_title(words)
        axes[-1, 0].get_legend().set_title(maps.END.words)
        layout.trim(figure)
        figure.savefig(ROOT / "docs" / "map.png", dpi=200)


def cells(name, C):
    """The cells of a config at one C."""
    study = load_study(read_document(ROOT / "config" / name))
    options = {**study.model, "horizon": study.settings.horizon, "threads": 2}
    model = options.pop("name")
    axes = {"N": study.axes["N"], "f0": study.axes["f0"], "C": [C]}
    return snapmap.sweep(study.device, **axes, model=model, **options).squeeze("C")


if __name__ == "__main__":
    main()
