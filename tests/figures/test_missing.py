"""Figures with all of their data missing, with one value, and with one among missing ones."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text
from small_results import make_cells, make_found, make_verdict
from small_studies import cases_of

import snapmap
from snapmap.applications.boundary.figure import draw_damage_boundary
from snapmap.applications.calibration.figure import draw as draw_calibration
from snapmap.applications.histories.figure import draw_history
from snapmap.applications.laws.figure import draw as draw_laws
from snapmap.applications.laws.laws import laws_of
from snapmap.applications.requirements.figure import draw_margins
from snapmap.applications.statics.figure import draw as draw_statics
from snapmap.applications.tolerances.figure import draw_stem
from snapmap.applications.window.figure import draw as draw_window
from snapmap.applications.window.window import window_of
from snapmap.figures import maps, style, thresholds
from snapmap.pulse.shocks import make_shocks
from snapmap.study.shock import Shock
from snapmap.study.study import Study

CASES = cases_of(__file__)
REQUIRED, SHOTS, GIVEN, SAYING = (CASES[key] for key in ("required", "shots", "given", "saying"))


@pytest.fixture(scope="module")
def made(handout):
    """A small result behind each figure, by the function that draws it."""
    study, followed = Study(handout, "3 cosines", horizon=100.0), Study(handout, "3 cosines")
    axes = {"C": [25.0], "f0": [500.0, 1500.0]}
    how = {"samples": 4, "index_samples": 4, "requirements": [REQUIRED | {"survives": True}]}
    points = {"thickness": np.array([1.9, 2.1]), "C": [25.0, 60.0]}
    edges = snapmap.threshold(followed, **axes)
    return {
        "cells": make_cells(["2225", "2022", "0020", "0100"]),
        "thresholds": make_found(),
        "laws": laws_of(study, study.set_out(axes), edges),
        "history": snapmap.simulate(study, 1000.0, 1500.0, 25.0),
        "statics": snapmap.statics(handout),
        "tolerances": snapmap.tolerance(study, {"thickness": 0.05}, **axes, **how),
        "calibration": snapmap.calibrate(followed, SHOTS, {"thickness": (1.7, 2.3)}, C=25.0),
        "verdicts": xr.Dataset({key: ("row", [one] * 2) for key, one in CASES["verdict"].items()}),
        "window": window_of(study, points, [Shock(**REQUIRED, shocks=make_shocks())]),
    }


def verdicts_of(data):
    return [make_verdict(**row) for row in data.to_dataframe().to_dict("records")]


def on_axes(draw, *arguments, **options):
    return lambda data, figure: draw(figure.subplots(), data, *arguments, **options)


def on_figure(draw, *arguments):
    return lambda data, figure: draw(figure, data, *arguments)


def draw_two_maps(figure, cells):
    return maps.draw_maps(figure, [(cells, None, ())] * 2, "f0", "N", (), "times")


FIGURES = {
    "snaps": ("cells", on_axes(maps.draw_map)),
    "times": ("cells", on_axes(maps.draw_map, shows="times")),
    "ends": ("cells", on_axes(maps.draw_map, shows="ends")),
    "maps": ("cells", on_figure(draw_two_maps)),
    "thresholds": ("thresholds", on_axes(thresholds.draw_thresholds)),
    "fields": ("thresholds", on_axes(thresholds.draw_threshold_map, "f0", "C")),
    "boundary": ("thresholds", on_axes(draw_damage_boundary)),
    "laws": ("laws", on_figure(draw_laws)),
    "history": ("history", lambda data, fig: draw_history(fig.subplots(3, sharex=True), data)),
    "statics": ("statics", on_figure(draw_statics)),
    **dict.fromkeys(("probability", "sensitivity", "yield"), ("tolerances", None)),
    "calibration": ("calibration", on_figure(draw_calibration)),
    "margins": ("verdicts", on_axes(lambda ax, data: draw_margins(ax, verdicts_of(data)))),
    "window": ("window", on_figure(draw_window, CASES["units"])),
}


def lost(data, kept):
    """The data, with as many first numbers of each computed variable as are kept, others NaN."""

    def lose(values):
        if values.dtype.kind != "f" or values.name in GIVEN:
            return values
        return values.where(np.arange(values.size).reshape(values.shape) < kept)

    return data.map(lose, keep_attrs=True)


def single(data):
    """The data at the first value of each axis."""
    return data.isel({key: [0] for key in {*CASES["axes"]} & {*data.dims}})


LOSSES = {"missing": lambda data: lost(data, 0), "alone": lambda data: lost(data, 1)}
LOSSES["single"] = single


@pytest.mark.usefixtures("paper")
@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_drawn_without_its_data_and_says_what_is_missing(made, monkeypatch, name, loss):
    if (name, loss) == ("window", "single"):
        return  # it has several values on both axes, or is not made
    kind, draw = FIGURES[name]
    data, saved = LOSSES[loss](made[kind]), []
    monkeypatch.setattr(style, "save", lambda figure, *_: saved.append(figure))
    if kind == "tolerances":  # its figures save themselves
        draw_stem(name, data)
    else:
        with style.saved(name, data.attrs, 3.4) as figure:
            draw(data, figure)
    (figure,) = saved
    figure.draw_without_rendering()
    texts = [text.get_text() for text in figure.findobj(Text)]
    assert not any("nan" in text.split() for text in texts), texts
    assert loss != "missing" or any(words in text for text in texts for words in SAYING), texts
