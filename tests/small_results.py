"""Small results of studies, for tests of figures and of the page."""

import json
from dataclasses import fields

import numpy as np
import xarray as xr

import snapmap
from snapmap.applications.requirements.verdict import Verdict
from snapmap.figures import style
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import OUTCOMES
from snapmap.solver.settings import Run
from snapmap.study.axes import attributes_of
from snapmap.study.variables import variables

CONFIG = {"model": {"name": "elements"}, "run": {"horizon": "1.5 ms"}}
CONFIG["histories"] = [{"N": 1000, "f0": "1500 Hz", "C": "0.025 uN*us/um"}]
AXES = {"C": [0.025, 200.0], "f0": [1000.0, 3000.0, 9000.0], "N": [800.0, 1000.0, 1300.0, 2200.0]}
SETTINGS = Run(horizon=300.0)
VARIABLES = variables("cube")
ATTRIBUTES = {"title": "A title", "code_version": "0.1.0+abc", "config": json.dumps(CONFIG)}


def swept(device, modes=3, cosines=None, skip=False, run=SETTINGS, **axes):
    """A cube of a device, in three cosines."""
    model = Cosines(modes=modes, cosines=cosines)
    study = snapmap.Study(device, model=model, skip=skip, **vars(run))
    axes = AXES | axes
    shock = {key: axes.pop(key) for key in AXES}
    return snapmap.sweep(study, **shock, axes=axes)


def make_cells(rows, f0=None, N=None):
    """Cells of C = 25 whose outcomes are digits: one row of text per N, the highest first.

    Those that snapped and did not return end in the second well, settled or seen.
    """
    outcome = np.array([[int(digit) for digit in row] for row in rows[::-1]], np.int8).T
    f0 = 100.0 * 4.0 ** np.arange(outcome.shape[0]) if f0 is None else f0
    N = 1000.0 + 100 * np.arange(outcome.shape[1]) if N is None else N
    flags = {"flag_values": np.arange(len(OUTCOMES)), "flag_meanings": " ".join(OUTCOMES)}
    near = {"label_distance": 0.01}
    snapped, tripped = np.isin(outcome, [2, 3, 4]), np.isin(outcome, [2, 3])
    variables = {
        "outcome": (("f0", "N"), outcome, VARIABLES["outcome"] | flags),
        "t_snap": (("f0", "N"), np.where(snapped, 100.0, np.nan), VARIABLES["t_snap"] | near),
        "well": (("f0", "N"), np.where(tripped, 2, 1).astype(np.int8), VARIABLES["well"]),
        "well_share": (("f0", "N"), np.ones(outcome.shape, np.float32), VARIABLES["well_share"]),
    }
    axes = {"C": ((), 25.0, attributes_of("C")), "f0": f0, "N": N}
    return xr.Dataset(variables, axes, ATTRIBUTES)


TINY = make_cells(["2225", "2022", "0020", "0100"])
F0 = np.array([100.0, 1000.0, 10000.0])


def make_found(C=(25.0, 200.0)):
    """Thresholds of several C at 100, 1000 and 10000 Hz; at the last two islands, and late."""
    N = np.array([1000.0, 1100.0, 2000.0]) + np.arange(len(C))[:, np.newaxis]
    gap = np.array([0.0, 0.0, 300.0])
    nan = np.full((len(C), 2, 2), np.nan)
    last = np.stack([N[:, 2:], N[:, 2:] + 100], axis=-1)
    axes = ("C", "f0")
    variables = {
        "N_first": (axes, N),
        "N_error": (axes, 0 * N + 7.0),
        "N_always": (axes, N + gap),
        "N_latched": (axes, 0 * N + np.nan),
        "t_snap": (axes, np.broadcast_to([5000.0, 500.0, 400.0], N.shape)),
        "islands": (axes, np.broadcast_to([0, 0, 2], N.shape)),
        "island_from": ((*axes, "island"), np.concatenate([nan, last], axis=1)),
        "island_to": ((*axes, "island"), np.concatenate([nan, last + 50], axis=1)),
        "N_bound": (axes, np.broadcast_to([180.0, 190.0, 630.0], N.shape)),
        "N_static": ((), 990.0),
        "dwell": ("C", np.full(len(C), np.nan)),
        "N_slow": (axes, 0 * N + np.nan),
        "area": ((), 0.5),
        "velocity_change": ("C", 0.5 + 0.1 * np.arange(len(C))),
    }
    return xr.Dataset(variables, {"C": list(C), "f0": F0}, ATTRIBUTES | {"gravity": 1e-5})


def make_history(*w_mid, t_snap=np.nan):
    """A history whose midpoint takes these positions, 10 us apart, 1 um below the mass."""
    w = np.array(w_mid, float)
    values = {"w_mid": w, "z_mass": w + 1, "contact_force": 0 * w, "acceleration": 0 * w + 0.02}
    columns = {key: ("time", column) for key, column in values.items()}
    columns |= {"second_equilibrium": -9.0, "gravity": 1e-5, "t_snap": t_snap}
    columns |= {"work_error": np.nan, "t_snap_error": np.nan}
    axes = {"time": 10.0 * np.arange(w.size), "N": 1000.0, "f0": 1500.0, "C": 0.025}
    return xr.Dataset(columns, axes, ATTRIBUTES)


def make_verdict(**values):
    """A verdict of a half sine of 1 ms along +z, met at 20 degC; other numbers are not known."""
    blank = {each.name: np.nan for each in fields(Verdict) if each.type is float}
    shock = {"requirement": "drop", "device": "", "shape": "half sine", "direction": "+z"}
    place = {"duration": 1.0, "C": 25.0, "temperature": 20.0, "must_snap": False}
    return Verdict(**blank | shock | place | {"outcome": "unsnapped", "verdict": "met"} | values)


def assert_same_cube(cube, other):
    """Two cubes have the same variables, bit for bit, and the same counts of outcomes."""
    assert set(cube.variables) == set(other.variables)
    for key in other.variables:
        assert cube[key].values.tobytes() == other[key].values.tobytes(), key
    counts = [key for key in other.attrs if key.startswith(("cells_", "share_"))]
    assert [cube.attrs[key] for key in counts] == [other.attrs[key] for key in counts]


def visible(line):
    """Points of a line that are not NaN."""
    return line.get_xydata()[~np.isnan(line.get_ydata())].tolist()


def legend_words(ax):
    return [text.get_text() for text in ax.figure.legends[0].get_texts()]


def drawn(draw, dataset, *others):
    """Axes on which a function has drawn a dataset."""
    return draw(style.double_column(height=3.4).subplots(), dataset, *others)


def artists(ax, kind):
    return [artist for artist in ax.get_children() if isinstance(artist, kind)]
