"""A device read off its shots."""

from pathlib import Path

import draw
import jobs
import numpy as np
import pytest
import xarray as xr
import yaml
from small_studies import THREE_COSINES

import snapmap
from snapmap.calibration.dataset import fit, summary
from snapmap.calibration.shots import shots_from
from snapmap.calibration.surface import Surface
from snapmap.config.study import load_config
from snapmap.config.yaml_file import ConfigError
from snapmap.io.tables import read_shots
from snapmap.pulse import HANDOUT_SHOCK

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0, "C": 25.0}
RANGE = {"thickness": (1.8, 2.2)}
LEVELS = [850.0, 900.0, 940.0, 960.0, 1000.0, 1100.0]
SHOTS = {"N": LEVELS, "duration": [1000.0] * 6, "tripped": [0, 0, 0, 1, 1, 1]}
TABLE = "N,duration (ms),tripped\n" + "".join(
    f"{N:g},1,{'yes' if trip else 'no'}\n" for N, trip in zip(LEVELS, SHOTS["tripped"], strict=True)
)


def straight(slopes, size=33):
    """Thresholds whose logarithms are linear over the unknowns, from -0.3 to 0.3 about 1000 g."""
    axes = np.meshgrid(*[np.linspace(-0.3, 0.3, size)] * slopes.shape[1], indexing="ij")
    logs = np.log(1000.0) + np.stack(axes, axis=-1) @ slopes.T
    names = ("thickness", "rise")[: slopes.shape[1]]
    return Surface(dict.fromkeys(names, (-0.3, 0.3)), logs)


def made_up(draw, surface, truth, spread, size=30, units=None):
    """Shots at a device of known values."""
    duration = np.where(np.arange(size) % 2, 500.0, 1000.0)
    logs = surface.at((np.array(truth) + 0.3) / 0.6)[0][np.arange(size) % logs_size(surface)]
    N = 1000.0 * np.exp(draw.uniform(-0.25, 0.25, size))
    apart = spread * draw.standard_normal(size)
    table = {"N": N, "duration": duration, "tripped": np.log(N) - logs > apart}
    return shots_from(table | ({} if units is None else {"unit": units}), HANDOUT_SHOCK, None)


def logs_size(surface):
    return surface.logs.shape[-1]


def test_intervals_cover_the_truth_of_made_up_campaigns():
    """Of ten that cover in 95 of 100 at least eight do, but for one in a hundred sets of them."""
    draw, surface = np.random.default_rng(1), straight(np.array([[1.0], [1.0]]))
    covered = 0
    for truth in np.linspace(-0.1, 0.1, 10):
        one = fit(made_up(draw, surface, [truth], 0.03), surface)
        covered += one.low.item() <= truth <= one.high.item()
        assert one.low < one.estimate < one.high and one.high - one.low < 0.2
    assert covered >= 8


def test_what_is_not_told_apart_is_said():
    """Thresholds depend on the sum alone: the difference of both is known from the ranges."""
    draw, surface = np.random.default_rng(2), straight(np.ones((2, 2)), size=17)
    found = fit(made_up(draw, surface, [0.0, 0.0], 0.03), surface)
    assert found.open_low.all() and found.open_high.all()
    assert found.correlation.values[0, 1] < -0.9
    assert "0.71 thickness" in found.untold and "0.71 rise" in found.untold
    assert "its range ends" in summary(found)


def test_residuals_are_those_of_the_fitted_probability():
    draw, surface = np.random.default_rng(3), straight(np.array([[1.0], [1.0]]))
    one = fit(made_up(draw, surface, [0.0], 0.05), surface)
    p = np.where(one.tripped, one.probability, 1 - one.probability)
    np.testing.assert_allclose(one.residual**2, -2 * np.log(p), rtol=1e-4, atol=1e-4)
    assert (np.sign(one.residual) == np.where(one.tripped, 1, -1))[p < 0.99].all()
    assert one.untold == "" and 0.01 < one.spread[0] < 0.2


def test_specimens_that_differ_share_a_spread():
    """All shots of a specimen change sides at its own threshold."""
    levels = np.tile(np.linspace(-0.2, 0.2, 8), 5)
    own = np.repeat([-0.1, -0.05, 0.0, 0.05, 0.1], 8)
    table = {"N": 1000 * np.exp(levels), "f0": [1e3] * 40, "tripped": levels > own + 1e-6}
    surface = straight(np.array([[1.0]]))
    units = np.repeat(list("abcde"), 8)
    found = fit(shots_from(table | {"unit": units}, HANDOUT_SHOCK, None), surface)
    assert found.unit_share[0] > 0.7 and 0.05 < found.spread[0] < 0.2
    alone = fit(shots_from(table, HANDOUT_SHOCK, None), surface)
    assert found.high - found.low > 1.5 * (alone.high - alone.low)


def test_shots_of_the_solver_itself_are_read_off(handout):
    found = snapmap.calibrate(handout, SHOTS, RANGE, **CHEAP)
    own = snapmap.threshold(
        handout, [1000.0], model="cosines", modes=3, horizon=300.0, C=[25.0], thickness=[1.9, 2.0]
    ).N_first.values.ravel()
    expected = 1.9 + 0.1 * (950.0 - own[0]) / (own[1] - own[0])
    assert found.estimate.item() == pytest.approx(expected, abs=0.005)
    assert found.low < found.estimate < found.high and found.model_error < 2e-3
    assert found.threshold.values == pytest.approx(950.0, abs=5.0)


def test_a_recorded_drop_is_a_shot(root, handout):
    path = str(root / "config" / "half_sine.csv")
    shots = {"file": [path] * 6, "N": LEVELS, "tripped": SHOTS["tripped"]}
    shots = shots_from(shots, HANDOUT_SHOCK, handout)
    assert shots.f0.tolist() == [2000.0] * 6 and len(shots.groups) == 1
    both = {"file": [path, "", ""], "duration": [np.nan, 500.0, 500.0], "tripped": [1, 0, 1]}
    mixed = shots_from(both | {"N": [np.nan, 900.0, 990.0]}, HANDOUT_SHOCK, handout)
    peak = snapmap.read_pulse(path).peak
    assert mixed.N[0] == peak / handout.gravity and len(mixed.groups) == 2


@pytest.mark.parametrize(
    ("change", "ranges", "complaint"),
    [
        ({"tripped": [1] * 6}, RANGE, "shots: all trip of 6; a threshold needs both"),
        ({"tripped": [0] * 6}, RANGE, "shots: none trips of 6"),
        ({"tripped": [1, 1, 1, 0, 0, 0]}, RANGE, "shots: they contradict each other, versed sine"),
        ({"tripped": [2] * 6}, RANGE, "shots, row 1: tripped: 2 is not true or false"),
        ({"N": [-1.0] * 6}, RANGE, "shots, row 1: N: .* is no number above 0"),
        ({"N": [9.81 * N for N in LEVELS]}, RANGE, "shots: N from 8338 to 1.079e.04, where the"),
        ({"N": [1.0]}, RANGE, "shots: "),
        ({"level": [1.0] * 6}, RANGE, "shots: column 'level' is unknown"),
        ({"f0": [1e3] * 6}, RANGE, "shots, row 1: f0 or duration: both are there"),
        ({"direction": ["up"] * 6}, RANGE, "shots, row 1: direction: 'up' is not one of"),
        ({"shape": ["square"] * 6}, RANGE, "shots, row 1: pulse.shape: 'square' is not one of"),
        ({"duration": [1e-9] * 6}, RANGE, "shots: outside the model's reach, no threshold of"),
        ({}, {"colour": (1, 2)}, "unknowns: {'colour'"),
        ({}, {"thickness": (2.2, 1.8)}, "unknowns: thickness: 2.2 to 1.8 is no ascending range"),
        ({}, {"thickness": 2.0}, "unknowns: thickness: 2.0 is no pair"),
        ({}, {"thickness": (2.0, 5.0)}, "unknowns: no second stable shape at thickness ="),
        ({}, {"C": (1.0, 50.0)}, "C: is unknown; leave it out"),
        ({}, {}, "unknowns: {} is not a mapping"),
    ],
)
def test_what_cannot_be_is_one_line(handout, change, ranges, complaint):
    with pytest.raises(ValueError, match=f"^{complaint}") as fault:
        snapmap.calibrate(handout, SHOTS | change, ranges, **CHEAP)
    assert "\n" not in str(fault.value)


def test_a_missing_column_is_named(handout):
    for key in ("N", "tripped"):
        table = {name: column for name, column in SHOTS.items() if name != key}
        with pytest.raises(ValueError, match=f"^shots: column {key} is missing"):
            snapmap.calibrate(handout, table, RANGE, **CHEAP)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "is empty"),
        ("N,duration,tripped\n", "header 'duration' names no unit"),
        ("N,N (g),tripped\n", "line 1: column N comes twice"),
        ("N,f0 (Hz),tripped\n900,soon,yes\n", "line 2, column f0: 'soon' is no number"),
        ("N,f0 (Hz),tripped\n900,1e3,maybe\n", "line 2, column tripped: 'maybe' is not yes or no"),
        ("N,f0 (Hz),tripped\n900,1,5,yes\n", "line 2: has more than 3 columns"),
    ],
)
def test_a_table_that_cannot_be_is_one_line(tmp_path, text, complaint):
    path = tmp_path / "shots.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=f"{path.name}: {complaint}"):
        read_shots(path)


def config(**calibration):
    document = yaml.safe_load(THREE_COSINES)
    sweep = {"N": [900, 1100], "f0": ["1 kHz"], "C": ["25 uN*us/um"], "horizon": "300 us"}
    return document | {"sweep": sweep, "calibration": calibration}


def test_the_config_has_a_calibration_and_its_figure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("shots.csv").write_text(TABLE, encoding="utf-8")
    study = load_config(config(shots="shots.csv", unknowns={"thickness": ["1.8 um", "2.2 um"]}))
    asked = study.calibration
    assert asked.unknowns == {"thickness": [1.8, 2.2]} and asked.C == 25.0
    assert study.files() == asked.files and list(asked.files) == ["shots.csv"]
    jobs.fit_calibration(study, "calibration.nc")
    draw.draw_calibration("calibration.nc", "calibration")
    with xr.open_dataset("calibration.nc") as found:
        assert 1.9 < found.estimate.item() < 2.1
    assert Path("calibration.pdf").exists() and Path("calibration.png").exists()


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"shots": "none.csv"}, "calibration: none.csv: is not there"),
        ({"shots": "../shots.csv"}, "calibration.shots: ../shots.csv lies outside"),
        ({"unknowns": {"thickness": ["2 um", "1 um"]}}, "calibration: unknowns: thickness: 2 to 1"),
        ({"unknowns": {"thickness": ["1.8", "2 um"]}}, "calibration.unknowns.thickness[0]: '1.8'"),
        ({"unknowns": {}}, "calibration: unknowns: 0 of them"),
    ],
)
def test_a_section_that_cannot_be_is_one_line(tmp_path, monkeypatch, change, complaint):
    monkeypatch.chdir(tmp_path)
    Path("shots.csv").write_text(TABLE, encoding="utf-8")
    given = {"shots": "shots.csv", "unknowns": {"thickness": ["1.8 um", "2.2 um"]}}
    with pytest.raises(ConfigError) as fault:
        load_config(config(**given | change))
    assert complaint.split("[")[0] in str(fault.value) and "\n" not in str(fault.value)
