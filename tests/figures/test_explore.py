"""The traces against histories, and the page in a browser."""

import json
import re
import shutil
from dataclasses import asdict, replace

import draw
import jobs
import numpy as np
import pytest
import xarray as xr
from playwright.sync_api import sync_playwright

import snapmap
from snapmap.figures.explore import page
from snapmap.figures.explore_cells import GREY, WORDS
from snapmap.figures.explore_device import device_rows
from snapmap.figures.states import SNAPS, STATES, end_elsewhere, end_states, snap_states
from snapmap.io.netcdf import read_earlier, write
from snapmap.motion import envelopes
from snapmap.solver.adaptive import Adaptive
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.trace import SAMPLE
from snapmap.solver.models import build_model
from snapmap.solver.outcome import ABSENT, OUTCOMES
from snapmap.solver.settings import MOVE, Settings
from snapmap.study import Study

MODEL = {"name": "cosines", "modes": 3}
SETTINGS = Settings(horizon=300.0)
AXES = {"C": [0.025, 200.0], "f0": [1000.0, 3000.0, 9000.0], "N": [800.0, 1000.0, 1300.0, 2200.0]}
ALWAYS, BAND, FIRST, APART = 1, 2, 3, 4
"""Which curve of the map is which."""
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)


def swept(device, **changes):
    asked = {**AXES, "model": "cosines", "modes": 3, "horizon": SETTINGS.horizon, **changes}
    return snapmap.sweep(device, **asked)


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


def trace(device, cube, model, settings, earlier=None):
    """The traces of a study of one device."""
    study = Study(device=device, model=model, settings=settings)
    return envelopes.trace(study, cube, earlier)


@pytest.fixture(scope="module")
def traced(handout, cube):
    return trace(handout, cube, MODEL, SETTINGS._replace(threads=2))


def test_traces_have_the_largest_stress_of_each_cell(handout, cube, traced):
    found = trace(replace(handout, strength=1500.0), cube, MODEL, SETTINGS)
    xr.testing.assert_equal(found.drop_vars(["stress_max", "strength"]), traced)
    assert found.strength == 1500
    for N in (cube.N[0], cube.N[-1]):
        cell = found.isel(C=0, f0=0).sel(N=N)
        N, f0, C = (cell[key].item() for key in ("N", "f0", "C"))
        run = snapmap.simulate(handout, N, f0, C, model=MODEL, horizon=SETTINGS.horizon)
        shown = run.stress.sel(time=slice(0, found.sizes["bin"] * cell.bin_length.item()))
        assert cell.stress_max.item() == pytest.approx(shown.max().item(), rel=0.05)


def edges_of(cube):
    """Thresholds of a cube, read off its grid: what the page needs of threshold.nc."""
    first = cube.N.where(cube.t_snap.notnull()).min("N")
    variables = {"N_first": first, "N_error": 0 * first + 20, "N_always": first + 50}
    return xr.Dataset(variables, attrs=cube.attrs)


def write_text(path, cube, traces):
    path.write_text(page(cube, traces, edges_of(cube), SETTINGS.horizon), encoding="utf-8")


def steps_of(model, N, f0, C):
    """The steps in which motions are followed, us; the axes broadcast."""
    return model.steps.of(to_cells(model.device, 0, N, f0, C, 0.0), SETTINGS.pulses, MOVE)


def history_of(device, cell):
    """The cell's history at the steps that a trace looks at, and the time between two looks."""
    run = snapmap.simulate(device, **cell, model="cosines", modes=3, horizon=SETTINGS.horizon)
    dt = steps_of(build_model(device, "cosines", modes=3), **cell).item()
    assert float(run.time[1] - run.time[0]) == pytest.approx(dt), "the history leaves out steps"
    return run.isel(time=slice(None, None, SAMPLE)), SAMPLE * dt


@pytest.mark.parametrize(("N", "f0", "C"), [(800.0, 9000.0, 200.0), (2200.0, 1000.0, 0.025)])
def test_traces_are_the_history(handout, traced, monkeypatch, N, f0, C):
    """The band ends at the extremes of each bin."""
    monkeypatch.setattr("snapmap.motion.history.SAMPLES", 10**6)
    run, look = history_of(handout, {"N": N, "f0": f0, "C": C})
    cell = traced.sel(N=N, f0=f0, C=C)
    per_bin = round(float(cell.bin_length) / look)
    bins = min(cell.sizes["bin"], run.sizes["time"] // per_bin)
    w = run.w_mid.values[: bins * per_bin].reshape(bins, per_bin)
    exact = {"rtol": 1e-6, "atol": 1e-6}
    np.testing.assert_allclose(cell.w_low[:bins], w.min(axis=1), **exact)
    np.testing.assert_allclose(cell.w_high[:bins], w.max(axis=1), **exact)
    starts = run.isel(time=slice(0, bins * per_bin, per_bin))
    np.testing.assert_allclose(cell.z_mass[:bins], starts.z_mass, **exact)
    stored = ("kinetic", "spring", "bending", "axial", "contact")
    energy = sum(starts[f"{kind}_energy"] for kind in stored) / run.attrs["barrier"]
    energy = np.minimum(energy.values, envelopes.ENERGY_REACH)
    np.testing.assert_allclose(cell.energy[:bins], energy, rtol=1e-6, atol=1e-6)
    assert (cell.beam_energy <= cell.energy).all()


def test_traces_are_the_sweeps_runs(handout):
    """They snap when the cube says, with one step for all that is asked."""
    N, f0, step = np.linspace(600, 2400, 12), np.geomspace(100, 3e4, 12), {"step": 0.5}
    cube = swept(handout, N=N, f0=f0, **step)
    traced = trace(handout, cube, MODEL | step, SETTINGS)
    snapped, w_2 = cube.t_snap.notnull(), handout.beam.second_equilibrium
    assert ((traced.w_low <= w_2).any("bin") == snapped).all()
    bin_of_snap = np.floor(cube.t_snap / traced.bin_length)
    assert not ((traced.bin < bin_of_snap) & (traced.w_low <= w_2)).any()
    soon = traced.bin <= bin_of_snap + 1
    assert ((soon & (traced.w_low <= w_2)).any("bin") == snapped).all()


def test_traces_show_the_proofs(cube, traced):
    """What is proven by all its energy ends below the saddle, and all that is proven is shown.

    Traces have steps of their own, in which a cell may end elsewhere if it does so in other steps.
    """
    outcome = cube.outcome.copy(data=np.array(OUTCOMES)[cube.outcome.values])
    proven = outcome.isin(["never", "returned"]) & (cube.reproduced == 1)
    assert proven.any() and (traced.energy.isel(bin=-1) < 1).where(proven, True).all()
    shown = traced.bin_length * traced.sizes["bin"]
    assert (shown >= 1e6 / cube.f0).all() and (shown >= cube.t_settled.fillna(0)).all()


def test_traces_end_where_the_sweep_did(handout):
    """A sweep that ends at the snap has proven its step good enough up to there, not beyond."""
    cube = swept(handout, until="snap")
    traced = trace(handout, cube, MODEL, SETTINGS._replace(until="snap"))
    shown = (traced.bin_length * traced.sizes["bin"]).where(cube.t_snap.notnull())
    assert shown.notnull().any() and (shown >= cube.t_snap).where(shown.notnull(), True).all()
    dt = build_model(handout, **MODEL).steps.longest[MOVE].item()
    look = SAMPLE * dt * traced.sizes["bin"]
    assert (shown - cube.t_snap).max() <= look
    # At the step of a trace the snap may come a bin later than in the sweep.
    second = traced.second_equilibrium
    left = (traced.w_low.min("bin") - second) / (handout.beam.rise - second)
    assert left.where(cube.t_snap.notnull()).max() < 0.05


def test_traces_do_not_depend_on_threads_or_order(handout, cube, traced):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    again = trace(handout, mixed, MODEL, SETTINGS)
    xr.testing.assert_equal(again, traced)


def test_a_large_grid_is_thinned_by_whole_strides(cube):
    axes = {"C": np.arange(5.0), "f0": np.arange(1.0, 211), "N": np.arange(301.0)}
    large = xr.Dataset({"outcome": (tuple(axes), np.zeros((5, 210, 301), np.int8))}, axes)
    thinned = envelopes.thin(large)
    assert np.unique(np.diff(thinned.f0)).size == np.unique(np.diff(thinned.N)).size == 1
    assert thinned.sizes["C"] == 5 and envelopes.CELLS / 2 < thinned.outcome.size <= envelopes.CELLS
    assert envelopes.thin(cube).sizes == cube.sizes


def test_a_failed_cell_is_kept_as_far_as_numbers_go(handout):
    """What blew up, or is beyond the largest numbers, has no trace."""
    failed = swept(handout, N=[800.0, 2200.0, 1e200], f0=[1000.0], C=[0.025])
    assert failed.outcome.values.ravel()[-1] == OUTCOMES.index("failed")
    found = trace(handout, failed, MODEL, SETTINGS)
    last = found.isel(N=-1)
    assert not last.isel(bin=0).energy.isnull()
    assert last.energy.isnull().any()
    assert float(abs(found.w_low).max()) <= 1.001 * envelopes.MOST


def test_an_adaptive_cell_is_traced_by_the_level_that_decided(handout, cube, monkeypatch):
    models = [{**MODEL, "step": step} for step in (0.5, 0.3)]

    def choose_model(device, model):
        base, top = (build_model(device, **one) for one in models)
        is_auto = model["name"] == "auto"
        return Adaptive(base, top, top) if is_auto else build_model(device, **model)

    monkeypatch.setattr(envelopes, "choose_model", choose_model)
    level = (cube.N > 900).astype(np.int8).broadcast_like(cube.outcome)
    found = trace(handout, cube.assign(level=level), {"name": "auto"}, SETTINGS)
    alone = [trace(handout, cube, model, SETTINGS).bin_length for model in models]
    assert (alone[0] != alone[1]).any()
    xr.testing.assert_equal(found.bin_length, xr.where(level == 0, *alone))


def test_devices_are_traced_as_each_alone(handout):
    """Also those of two kinds of model, with a contact that is hard and one that is not."""
    model = {**MODEL, "cosines": 4}
    asked = {**AXES, **model, "model": model["name"], "horizon": SETTINGS.horizon}
    del asked["name"]
    points = {"thickness": [1.8, 4.4], "contact": [40.0, np.inf]}
    cube = snapmap.sweep(handout, **asked, **points, skip=True)
    traced = trace(handout, cube, model, SETTINGS)
    assert traced.second_equilibrium.dims == ("thickness", "contact")
    for contact in points["contact"]:
        thin = replace(handout.beam, thickness=1.8)
        device = replace(handout, beam=thin, contact=contact)
        own = snapmap.sweep(device, **asked)
        alone = trace(device, own, model, SETTINGS)
        there = traced.sel(thickness=1.8, contact=contact)
        assert float(there.second_equilibrium) == device.beam.second_equilibrium
        np.testing.assert_array_equal(there.bin_length, alone.bin_length)
        for key in envelopes.VARIABLES:
            np.testing.assert_array_equal(there[key], alone[key])
    absent = traced.sel(thickness=4.4)
    assert absent.energy.isnull().all() and absent.second_equilibrium.isnull().all()


def test_what_follows_the_horizon_spoils_no_range(handout, cube, traced, monkeypatch):
    """Bins go on beyond it, where a run that was believed may blow up."""
    follow = envelopes._follow

    def blow_up(model, pulses, cells, window, bins, threads):
        values, bin_length, stress = follow(model, pulses, cells, window, bins, threads)
        begins = np.arange(bins)[:, np.newaxis] * bin_length
        values[:, begins > window] = 1e280
        assert (begins > window).any()
        return values, bin_length, stress

    monkeypatch.setattr(envelopes, "_follow", blow_up)
    found = trace(handout, cube, MODEL, SETTINGS)
    for key in ("w_high", "z_mass", "energy"):
        np.testing.assert_array_equal(found[key].max("bin") <= traced[key].max("bin"), True)


def test_traces_that_grow_are_those_followed_at_once(handout, cube, traced, tmp_path, monkeypatch):
    """As files: what is kept of a number does not hang on how often it was written."""
    part = trace(handout, cube.isel(f0=[0, 2], C=[1]), MODEL, SETTINGS)
    write(part, tmp_path / "part.nc")
    write(traced, tmp_path / "whole.nc")
    follow, followed = envelopes._follow, []

    def counted(model, pulses, cells, *asked):
        followed.append(cells.f0.size)
        return follow(model, pulses, cells, *asked)

    monkeypatch.setattr(envelopes, "_follow", counted)
    grown = trace(handout, cube, MODEL, SETTINGS, earlier=read_earlier(tmp_path / "part.nc"))
    assert sum(followed) == cube.outcome.size - 8
    write(grown, tmp_path / "grown.nc")
    with (
        xr.open_dataset(tmp_path / "grown.nc") as one,
        xr.open_dataset(tmp_path / "whole.nc") as other,
    ):
        xr.testing.assert_identical(one, other)


def test_the_reference_is_traced_by_its_elements_in_modes(handout, cube):
    model = {"name": "reference", "elements": 2}
    as_reference = trace(handout, cube, model, SETTINGS)
    as_handout = trace(handout, cube, {**model, "name": "handout"}, SETTINGS)
    xr.testing.assert_equal(as_reference, as_handout)


@pytest.fixture(scope="module")
def page_file(handout, cube, tmp_path_factory):
    """The page of the small cube, made by the rules' own functions."""
    folder = tmp_path_factory.mktemp("a page")
    names = ("cube.nc", "traces.nc", "threshold.nc", "explore.html")
    paths = [folder / name for name in names]
    write(cube, paths[0])
    study = {"device": asdict(handout), "pulse": {}, "model": MODEL, "skip": False}
    study["settings"] = SETTINGS.asked()
    jobs.trace_cells(paths[0], study, paths[1], threads=1)
    write(edges_of(cube), paths[2])
    draw.write_page(*paths[:3], SETTINGS.horizon, paths[3])
    assert sorted(folder.iterdir()) == sorted(paths)
    return paths[3]


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


class View:
    """A page in a browser, what it asked for and what it complained of."""

    def __init__(self, browser, path, **kind):
        self.page, self.requests, self.complaints = browser.new_page(**kind), [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(path.as_uri())
        self.wait("document.getElementById('verdict').textContent")
        self.opened = self.place()

    def wait(self, condition):
        """Wait until it holds; Playwright's own way to wait is a script that the page forbids."""
        for _ in range(500):
            if self.page.evaluate(condition):
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(condition)

    def text(self, selector):
        text = self.page.text_content(selector)
        return text.replace("\u200b", "").replace("\xa0", " ")

    def shown(self, figure, key, curve=0):
        """What a curve of a figure shows, as plain lists."""
        return self.page.evaluate(
            f"JSON.parse(JSON.stringify(document.getElementById('{figure}').data[{curve}].{key}))"
        )

    def point_at(self, i, j):
        """Where in the window the cell of the i-th x and the j-th y is drawn."""
        return self.page.evaluate(
            """([i, j]) => {
                const { xaxis, yaxis } = map._fullLayout;
                const box = map.querySelector(".nsewdrag").getBoundingClientRect();
                const [x, y] = [axes[X].values[i], axes[Y].values[j]];
                return [box.x + xaxis.d2p(x), box.y + yaxis.d2p(y)];
            }""",
            [i, j],
        )

    def hover(self, i, j):
        self.page.mouse.move(0, 0)
        self.page.wait_for_selector("#map .hovertext", state="detached")
        self.page.mouse.move(*self.point_at(i, j))
        self.page.wait_for_selector("#map .hovertext")
        return self.text("#map .hovertext")

    def click(self, i, j):
        self.hover(i, j)
        self.page.mouse.click(*self.point_at(i, j))
        self.wait_for(i, j)

    def wait_for(self, i, j):
        """Wait until the cell of the i-th x and the j-th y is the chosen one."""
        self.wait(f"at[X] === {i} && at[Y] === {j}")

    def slide(self, index, key="C"):
        self.page.fill(f"#at-{key}", str(index))

    def choose(self, words):
        self.page.check(f"#views label:has-text('{words}') input")

    def sliders(self):
        """The label and the value of each slider."""
        rows = "[...document.querySelectorAll('#sliders input')].map((slider) => ["
        rows += "slider.labels[0].textContent, slider.nextElementSibling.textContent])"
        return [[text.replace("\xa0", " ") for text in row] for row in self.page.evaluate(rows)]

    def values(self):
        """The rows of the table of the device."""
        rows = "[...document.querySelectorAll('#values tr')].map((row) => row.innerText)"
        return dict(row.replace("\xa0", " ").split("\t") for row in self.page.evaluate(rows))

    def place(self):
        """Where the chosen cell is on each axis."""
        return self.page.evaluate("at")


@pytest.fixture(scope="module")
def view(browser, page_file):
    return View(browser, page_file)


def codes_of(cube, c):
    return snap_states(cube.isel(C=c)).transpose("N", "f0").values.tolist()


def test_the_page_is_alone_and_sends_the_study_nowhere(browser, page_file):
    view = View(browser, page_file)
    view.click(0, 3)
    view.slide(1)
    assert view.requests == [page_file.as_uri()]
    buttons = view.page.query_selector_all(".modebar-btn")
    titles = [button.get_attribute("data-title") for button in buttons]
    assert len(titles) > 4 and not [title for title in titles if re.search("hare|loud|dit", title)]
    for button in buttons:
        button.evaluate("button => button.click()")
    view.page.set_viewport_size({"width": 420, "height": 800})
    view.wait("document.documentElement.scrollWidth <= 420")
    assert not [url for url in view.requests if not url.startswith(("file:", "blob:", "data:"))]
    assert view.complaints == []
    asked = "fetch('https://example.org/').then(() => 'sent', () => 'refused')"
    assert view.page.evaluate(asked) == "refused"
    assert any("Content Security Policy" in complaint for complaint in view.complaints)


def test_the_slider_changes_the_map(view, cube):
    assert codes_of(cube, 0) != codes_of(cube, 1)
    for c, words in enumerate(("0.025 µN µs/µm", "200 µN µs/µm")):
        view.slide(c)
        assert view.shown("map", "z") == codes_of(cube, c)
        assert view.sliders() == [["damping of the mass C", words]]
        assert view.page.get_attribute("#at-C", "aria-valuetext").replace("\xa0", " ") == words
        assert f"C = {words}" in view.text("#cell")
        assert view.shown("map", "x", curve=APART) == []


def test_the_classes_are_named_and_counted(view, cube):
    view.slide(0)
    counts = np.bincount(np.ravel(codes_of(cube, 0)), minlength=len(SNAPS))
    for state, count in zip(SNAPS, counts, strict=True):
        assert (f"{state.words} ({count})" in view.text("#classes")) == (count > 0)


def test_a_switch_shows_when_cells_snap_and_where_they_end(view, cube):
    """Lines are those of snapping, hatches those of ends; each time is a colour of its own."""
    view.slide(0)
    cells = cube.isel(C=0).transpose("N", "f0")
    view.choose("time")
    shown = np.array(view.shown("map", "z"))
    times = cells.t_snap.values
    snaps = np.isfinite(times)
    assert (shown[~snaps] == 0).all() and (abs(shown[snaps] - 1) < 0.5).all()
    assert (np.argsort(shown[snaps]) == np.argsort(times[snaps])).all()
    first, last = (f"{end / 1e3:.4g} ms" for end in (cube.t_snap.min(), cube.t_snap.max()))
    said = view.text("#classes")
    assert f"{first} {last}, first snap ({snaps.sum()})" in said and "no snap seen" in said
    view.choose("where it ends")
    assert view.shown("map", "z") == end_states(cells).values.tolist()
    assert len(view.shown("map", "x", curve=APART)) == end_elsewhere(cells).sum() > 0
    assert view.shown("map", "y", FIRST) == []
    view.choose("snaps")
    assert view.shown("map", "z") == codes_of(cube, 0) and view.shown("map", "y", FIRST) != []


def test_a_cell_says_what_it_is_under_the_pointer(view, cube):
    view.slide(1)
    i, j = np.argwhere(np.isfinite(cube.t_snap.isel(C=1).values))[0]
    cell = cube.isel(C=1, f0=i, N=j)
    words = STATES[int(end_states(cell))].words, WORDS[OUTCOMES[int(cell.outcome)]]
    time = f"{float(cell.t_snap):.4g}"
    expected = [*words, f"N = {cell.N:g}", f"f0 = {cell.f0:g} Hz", f"tsnap = {time} µs"]
    text = view.hover(int(i), int(j))
    assert all(part in text for part in expected), text


def test_the_thresholds_are_drawn_for_the_chosen_values(view, cube):
    """N_always, the band of the error about N_first, once there and back, and N_first."""
    found = edges_of(cube)
    assert found.N_first.notnull().all() and (found.N_first[0] != found.N_first[1]).any()
    for c in range(2):
        view.slide(c)
        row = found.isel(C=c)
        for curve, N in ((FIRST, row.N_first), (ALWAYS, row.N_always)):
            assert view.shown("map", "x", curve) == cube.f0.values.tolist()
            assert view.shown("map", "y", curve) == pytest.approx(N.values.tolist())
        band = [*(row.N_first + 20).values, *(row.N_first - 20).values[::-1]]
        assert view.shown("map", "y", BAND) == pytest.approx([*band, None])
        view.click(1, 0)
        first, always = row.N_first.values[1], row.N_always.values[1]
        assert f"{first:g} ± 20; above {always:g} all snap" in view.text("#edge")


def test_a_band_is_left_out_where_no_error_is_known(browser, cube, traced, tmp_path):
    found = edges_of(cube)
    found.N_first[0, 2], found.N_error[0, 1] = np.nan, np.inf
    (tmp_path / "page.html").write_text(page(cube, traced, found, 300.0), encoding="utf-8")
    view = View(browser, tmp_path / "page.html")
    view.slide(0)
    first = found.N_first.values[0, 0]
    assert view.shown("map", "y", BAND) == [first + 20, first - 20, None]
    view.click(1, 3)
    assert "±" not in view.text("#edge")
    view.click(2, 3)
    assert "nothing snaps" in view.text("#edge")


def test_the_axis_above_is_the_duration(view):
    ticks = view.page.evaluate("map.layout.xaxis2")
    durations = [float(text) for text in ticks["ticktext"]]
    assert durations == pytest.approx([1e3 / f0 for f0 in ticks["tickvals"]])
    shown = "[...map.querySelectorAll('.x2tick text')].map((tick) => tick.textContent)"
    assert set(view.page.evaluate(shown)) == set(ticks["ticktext"])


def test_a_click_shows_the_history_of_that_cell(view, traced):
    """Each curve to half a step of its own range, of which there are 254."""
    view.slide(0)
    for i, j in ((0, 3), (2, 0)):
        view.click(i, j)
        cell = traced.isel(C=0, f0=i, N=j)
        for curve, key in enumerate(("w_low", "w_high", "z_mass", "energy", "beam_energy")):
            half = 0.501 * float(cell[key].max() - cell[key].min()) / 254
            shown = view.shown("history", "y", curve)
            assert shown == pytest.approx(cell[key].values.tolist(), abs=half)
        starts = float(cell.bin_length) / 1e3 * np.arange(cell.sizes["bin"])
        assert view.shown("history", "x", 2) == pytest.approx(starts.tolist())
        assert view.text("#cell").startswith(f"N = {cell.N:g}, f0 = {cell.f0:g} Hz")


def test_the_arrow_keys_move_the_choice(view):
    view.click(1, 1)
    view.page.focus("#keys")
    for key, cell in (("Right", (2, 1)), ("Right", (2, 1)), ("Up", (2, 2)), ("Left", (1, 2))):
        view.page.keyboard.press(f"Arrow{key}")
        view.wait_for(*cell)


def test_the_buttons_move_the_choice(view):
    view.click(1, 1)
    for name, cell in (("next f0", (2, 1)), ("previous N", (2, 0)), ("previous f0", (1, 0))):
        view.page.click(f"button[aria-label='{name}']")
        view.wait_for(*cell)


def test_a_sentence_says_how_the_label_is_known(view, cube):
    for c, i, j in np.ndindex(cube.outcome.shape):
        name = OUTCOMES[int(cube.outcome[c, i, j])]
        view.page.evaluate(f"at[0] = {c}; choose({i}, {j})")
        text, cell = view.text("#verdict"), cube.isel(C=c, f0=i, N=j)
        assert text.startswith(STATES[int(end_states(cell))].words)
        for key, known in (("t_snap", "reached the second"), ("t_settled", "proven")):
            seen = bool(np.isfinite(cell[key]))
            assert (known in text) == seen
            assert not seen or f"t = {float(cell[key]):.4g} µs" in text
        is_open = name in ("snapped", "unsnapped")
        assert ("open" in text) == ("of the mass's last swing" in text) == is_open


def test_a_sentence_says_by_how_much_another_step_differs(view, cube):
    """Rounded to two digits; of the snap only where both runs saw it."""
    for c, i, j in np.ndindex(cube.outcome.shape):
        view.page.evaluate(f"at[0] = {c}; choose({i}, {j})")
        text, cell = view.text("#verdict"), cube.isel(C=c, f0=i, N=j)
        pattern = "With another step, which indicates the error, the work of the pulse "
        pattern += r"differs by (\S+) %"
        pattern += r"(?:, the time of snap by (\S+) µs)?\.$"
        work, time = re.search(pattern, text).groups()
        assert float(work) == pytest.approx(100 * float(cell.work_error), rel=0.051)
        assert (time is None) == bool(np.isnan(cell.t_snap_error))
        assert time is None or float(time) == pytest.approx(float(cell.t_snap_error), rel=0.051)


def test_a_sentence_says_on_which_side_the_beam_was_last(browser, cube, traced, tmp_path):
    """By its share of the mass's last swing, and only where nothing is proven."""
    cells, proof = cube.copy(deep=True), np.isfinite(cube.t_settled.values)
    open_cell, proven = (
        dict(zip(cube.outcome.dims, np.argwhere(known)[0].tolist(), strict=True))
        for known in (~proof, proof)
    )
    cells.well[open_cell], cells.well_share[open_cell] = 2, 0.8399
    write_text(tmp_path / "page.html", cells, traced)
    view, said = View(browser, tmp_path / "page.html"), "on the second side during 83 %"
    for cell, is_said in ((open_cell, True), (proven, False)):
        view.slide(cell["C"])
        assert (said in view.hover(cell["f0"], cell["N"])) == is_said
        view.click(cell["f0"], cell["N"])
        assert (said in view.text("#verdict")) == is_said


def test_energies_are_told_as_before_they_were_packed(browser, cube, traced, tmp_path):
    """A byte would not tell the first two apart; the last are beyond what is kept, or not quite."""
    names = ["latched", "latched", "snapped", "snapped"]
    codes = xr.DataArray([OUTCOMES.index(name) for name in names], dims="N")
    cells = cube.assign(outcome=codes.broadcast_like(cube.outcome).assign_attrs(cube.outcome.attrs))
    cells = cells.assign(t_settled=xr.full_like(cube.t_settled, 100.0).where(codes == codes[0]))
    most = envelopes.ENERGY_REACH
    late = xr.DataArray([1 + 1e-3, 1 - 1e-3, most, most - 0.01], dims="N")
    energy = xr.where((traced.bin < 1) & (late < 2), 4.0, late, keep_attrs=False)
    energy = energy.broadcast_like(traced.energy).transpose(*traced.energy.dims)
    energies = traced.assign(energy=energy.assign_attrs(traced.energy.attrs))
    write_text(tmp_path / "page.html", cells, energies)
    view, said = View(browser, tmp_path / "page.html"), []
    for j in range(4):
        view.page.evaluate(f"at[0] = 0; choose(1, {j})")
        said.append(view.text("#verdict"))
    assert ["the mass swings too weakly" in text for text in said[:2]] == [True, False]
    assert "at least 4 times" in said[2] and "is 3.99 times" in said[3]


def test_weak_shocks_are_traced_without_steps(handout, tmp_path):
    """A thousandth of the usual shock, too, has as many steps as the page can show."""
    weak = swept(handout, N=[1.0], f0=[3000.0], C=[25.0])
    write(trace(handout, weak, MODEL, SETTINGS), tmp_path / "traces.nc")
    with xr.open_dataset(tmp_path / "traces.nc") as kept:
        for key in ("w_low", "w_high", "z_mass"):
            values = np.unique(kept[key].values[np.isfinite(kept[key].values)])
            assert np.diff(values).min() < np.ptp(values) / 50


PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


@pytest.fixture(scope="module")
def phone(browser, page_file):
    view = View(browser, page_file, **PHONE)
    yield view
    assert view.complaints == []


def test_a_phone_shows_all_in_one_column(phone):
    assert phone.page.evaluate("document.documentElement.scrollWidth") == 390
    boxes = [phone.page.query_selector(f"#{name}").bounding_box() for name in ("map", "history")]
    assert boxes[0]["y"] + boxes[0]["height"] <= boxes[1]["y"]
    assert all(box["width"] > 330 and box["x"] + box["width"] <= 390 for box in boxes)
    assert not phone.page.is_visible(".modebar-container")


def test_a_finger_chooses_slides_and_steps(phone):
    for control in phone.page.query_selector_all("#views label, #sliders input, #steps button"):
        assert control.bounding_box()["height"] >= 44
    phone.page.touchscreen.tap(*phone.point_at(2, 3))
    phone.wait_for(2, 3)
    phone.page.tap("button[aria-label='previous f0']")
    phone.wait_for(1, 3)


def test_a_finger_scrolls_over_the_map(phone):
    x, y = phone.point_at(1, 1)
    before = phone.page.evaluate("map.layout.yaxis.range")
    touch = phone.page.context.new_cdp_session(phone.page)
    for kind, far in (("touchStart", 0), *(("touchMove", far) for far in range(10, 210, 10))):
        points = [{"x": x, "y": y - far}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    phone.wait("window.scrollY > 100")
    assert phone.page.evaluate("map.layout.yaxis.range") == before


def large_study(cube, traced):
    """A cube of 40 000 cells and traces that compress as badly as real ones, about by half."""
    rng = np.random.default_rng(3)
    axes = {"C": 4, "f0": 100, "N": 100}
    values = {key: np.arange(1.0, size + 1) for key, size in axes.items()}
    code = rng.integers(0, ABSENT, tuple(axes.values()), np.int8)
    t_snap = rng.uniform(10, 1000, code.shape)
    large = xr.Dataset(
        {
            "outcome": (tuple(axes), code, cube.outcome.attrs),
            "t_snap": (tuple(axes), t_snap),
            "t_settled": (tuple(axes), t_snap),
            "well": (tuple(axes), rng.integers(1, 3, code.shape, np.int8)),
            "well_share": (tuple(axes), rng.uniform(0, 1, code.shape)),
        },
        values,
        cube.attrs,
    )
    shape = envelopes.BINS[-1], *code.shape
    noise = rng.integers(0, 12, shape) + np.linspace(0, 254, shape[0])[:, None, None, None]
    kept = {key: (("bin", *axes), noise, traced[key].attrs) for key in envelopes.VARIABLES}
    kept["bin_length"] = (tuple(axes), np.ones(code.shape, np.float32))
    kept["second_equilibrium"] = traced.second_equilibrium
    return large, xr.Dataset(kept, values, traced.attrs)


def test_a_page_of_40_000_cells_is_small_and_answers(browser, cube, traced, tmp_path):
    path = tmp_path / "large.html"
    write_text(path, *large_study(cube, traced))
    assert path.stat().st_size < 15e6
    view = View(browser, path)
    before = view.shown("history", "y", 2)
    view.click(10, 20)
    assert view.shown("history", "y", 2) != before
    before = view.shown("map", "z")
    view.slide(4)
    assert view.shown("map", "z") != before
    assert view.complaints == []


def test_a_thinned_page_says_so(cube, traced):
    some, found = traced.isel(N=slice(None, None, 2)), edges_of(cube)
    assert "Shown are 2 of 4 N of the cube." in page(cube, some, found, 300.0)
    fewer = page(cube, some.isel(C=[0], f0=slice(None, None, 2)), found, 300.0)
    assert "Shown are 1 of 2 C, 2 of 3 f0 and 2 of 4 N of the cube." in fewer
    assert "Shown are" not in page(cube, traced, found, 300.0)


def test_text_from_a_config_is_text(cube, traced):
    document = json.loads(cube.attrs["config"])
    document["model"]["name"] = "<b>bold</b>"
    document["devices"] = {"<b>bold</b>": document.pop("device")}
    named = cube.assign_attrs(config=json.dumps(document))
    text = page(named, traced, edges_of(cube), SETTINGS.horizon)
    assert text.count("&lt;b&gt;bold") == 3 and "<b>bold</b>" not in text
    (row,) = device_rows({"device": {"spring": "<b>bold</b>"}})[""]
    assert row[2] == "&lt;b&gt;bold&lt;/b&gt;"


def view_of(browser, path, device, **asked):
    """The cube of a device, or of several, and its page in a browser."""
    cube = swept(device, **asked)
    model = json.loads(cube.attrs["config"])["model"]
    asked_for = SETTINGS._replace(until=asked.get("until", SETTINGS.until))
    write_text(path, cube, trace(device, cube, model, asked_for))
    return cube, View(browser, path)


def shows(view, cells, x, y, states=snap_states):
    """Whether the map is that of some cells, and of the axes x and y."""
    codes = states(cells).transpose(y, x).values.tolist()
    return view.shown("map", "z") == codes


@pytest.fixture(scope="module")
def of_devices(browser, handout, tmp_path_factory):
    """Two axes of the device, one of which has points without a second stable shape."""
    path = tmp_path_factory.mktemp("devices") / "explore.html"
    axes = {"C": [25.0], "thickness": [1.8, 2.0, 4.4], "spring": [4.0, 7.0]}
    return view_of(browser, path, handout, **axes, skip=True)


def test_each_further_axis_of_several_values_has_a_slider(of_devices):
    cube, view = of_devices
    view.choose("where it ends")
    maps = set()
    for t, s in np.ndindex(3, 2):
        view.slide(t, "thickness")
        view.slide(s, "spring")
        cells = cube.isel(thickness=t, spring=s, C=0)
        assert shows(view, cells, "f0", "N", end_states)
        maps.add(end_states(cells).values.tobytes())
        values = [f"{cells.thickness:g} µm", f"{cells.spring:g} N/m"]
        assert view.sliders() == [["thickness", values[0]], ["spring", values[1]]]
        assert view.page.get_attribute("#at-spring", "aria-valuetext") == values[1].replace(
            " ", "\xa0"
        )
        heading = f"C = 25 µN µs/µm, spring = {values[1]}, thickness = {values[0]}"
        assert view.text("#cell").endswith(heading)
    assert len(maps) == 5, "the maps of some devices are alike"
    view.choose("snaps")
    assert view.complaints == []


def test_each_device_has_its_own_second_shape(of_devices):
    cube, view = of_devices
    view.slide(0, "spring")
    levels = []
    for t in range(2):
        view.slide(t, "thickness")
        levels.append(view.page.evaluate("motion.layout.shapes[0].y0"))
    ratio = 4 / np.sqrt(3) * cube.thickness.values[:2] / 10
    assert levels == pytest.approx((-5 * (1 + np.sqrt(1 - ratio**2))).tolist(), rel=1e-6)


def test_a_cell_without_a_device_says_so_and_shows_no_curves(of_devices):
    _, view = of_devices
    view.slide(2, "thickness")
    view.click(1, 2)
    words = WORDS["absent"]
    assert view.text("#verdict").startswith(f"{words}: ")
    assert view.text("#classes") == f"{words} (12)"
    assert not view.page.is_visible("#history")
    colours = view.shown("map", "colorscale")
    assert colours[-1][1] == GREY
    hovered = view.hover(0, 0)
    assert words in hovered and "snap =" not in hovered and "no snap" not in hovered
    view.slide(0, "thickness")
    assert view.page.is_visible("#history") and view.shown("history", "y", 2)[0] is not None
    assert view.complaints == []


def test_the_table_has_the_values_of_the_chosen_device(of_devices, handout):
    _, view = of_devices
    for t, thickness in enumerate(("1.8 µm", "2 µm")):
        view.slide(t, "thickness")
        values = view.values()
        assert values["thickness t"] == thickness and values["span L"] == "600 µm"
        assert values["gravity"] == f"{handout.gravity * 1e6:g} m/s²"


def test_the_frequencies_of_the_device_are_told(view, handout, cube):
    shown = view.text("#vibration")
    assert shown == snapmap.describe(handout, cube.C.values)


def test_the_keyboard_moves_a_slider(of_devices):
    cube, view = of_devices
    view.slide(0, "thickness")
    view.slide(0, "spring")
    view.page.focus("#at-spring")
    view.page.keyboard.press("ArrowRight")
    assert shows(view, cube.isel(thickness=0, spring=1, C=0), "f0", "N")


def test_devices_are_shown_by_their_names(browser, handout, tmp_path):
    devices = {"made": handout, "thin": replace(handout, spring=3.0)}
    cube, view = view_of(browser, tmp_path / "page.html", devices, C=[25.0])
    for d, name in enumerate(devices):
        view.slide(d, "device")
        assert shows(view, cube.isel(device=d, C=0), "f0", "N")
        assert view.sliders() == [["device", name]]
        assert view.text("#cell").endswith(f"device {name}")
        assert view.values()["spring K"] == f"{devices[name].spring:g} N/m"
        assert view.text("#device") == f"The device {name}"
    assert view.complaints == []


def test_a_name_is_text_and_stands_at_its_place(browser, handout, tmp_path):
    devices = {"<b>a</b>": handout, "b": replace(handout, spring=3.0)}
    cube, view = view_of(browser, tmp_path / "page.html", devices, f0=[3000.0], C=[25.0])
    assert shows(view, cube.isel(f0=0, C=0), "device", "N") and view.sliders() == []
    view.click(0, 1)
    assert view.text("#cell") == "N = 1000, f0 = 3000 Hz, C = 25 µN µs/µm, device <b>a</b>"
    assert view.text("#map .xaxislayer-above") == "<b>a</b>b"


def test_a_hard_contact_is_a_word(browser, handout, tmp_path):
    axes = {"contact": [20.0, 40.0, np.inf], "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **axes, cosines=4)
    for c, text in enumerate(("20 N/m", "40 N/m", "hard")):
        view.slide(c, "contact")
        assert view.sliders() == [["contact", text]]
        assert shows(view, cube.isel(contact=c, C=0), "f0", "N")


@pytest.mark.parametrize("single", ["f0", "N"])
def test_where_one_has_one_value_the_longest_other_takes_its_place(
    browser, handout, tmp_path, single
):
    axes = {"thickness": [1.8, 1.9, 2.0, 2.2], "spring": [4.0, 7.0], single: [1500.0], "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **axes)
    x, y = ("thickness", "N") if single == "f0" else ("f0", "thickness")
    for s, words in enumerate(("4 N/m", "7 N/m")):
        view.slide(s, "spring")
        assert view.sliders() == [["spring", words]]
        assert shows(view, cube.isel({"spring": s, single: 0, "C": 0}), x, y)
    view.click(2, 1)
    assert view.place() == ([2, 1, 0, 0, 1] if single == "f0" else [1, 1, 0, 2, 0])
    ends = [float(end) for end in view.page.evaluate("[motion.layout.shapes[2].x0]")]
    assert ends == pytest.approx([1e3 / float(cube.f0[0 if single == "f0" else 2])])
    assert (view.shown("map", "y", FIRST) == []) == (y != "N")
    assert view.page.evaluate("'xaxis2' in map.layout") == (x == "f0")
    titles = view.page.evaluate("[map.layout.xaxis.title.text, map.layout.yaxis.title.text]")
    assert any("thickness (µm)" in title for title in titles)


def test_a_sweep_to_the_snap_shows_where_it_snaps(browser, handout, tmp_path):
    """Nothing is known of what follows, and nothing said."""
    cube, view = view_of(browser, tmp_path / "page.html", handout, C=[25.0], until="snap")
    assert "well" not in cube
    snaps = cube.t_snap.notnull().isel(C=0)
    assert view.shown("map", "z") == snaps.astype(int).transpose("N", "f0").values.tolist()
    for state, count in zip(SNAPS, ((~snaps).sum(), snaps.sum()), strict=False):
        assert f"{state.words} ({int(count)})" in view.text("#classes")
    said = [view.hover(i, j) for i, j in np.ndindex(3, 4)]
    said += [view.text("#verdict"), view.text("#classes")]
    assert not [text for text in said if "tripped" in text or "swing" in text]


def test_a_cell_alone_is_a_page(browser, handout, tmp_path):
    asked = {"N": [1000.0], "f0": [1500.0], "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **asked)
    assert shows(view, cube.isel(C=0), "f0", "N") and view.sliders() == []
    assert view.text("#cell") == "N = 1000, f0 = 1500 Hz, C = 25 µN µs/µm"


def test_the_page_opens_at_the_threshold_near_the_middle(browser, handout, tmp_path):
    """The middle spring snaps everywhere or nowhere, so that another has to be shown."""
    springs = [1.0, 4.0, 7.0, 500.0, 600.0, 700.0, 800.0]
    axes = {"spring": springs, "N": np.linspace(600, 2400, 9), "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **axes)
    snaps = np.isfinite(cube.t_snap.values[:, 0])
    mixed = [s for s in range(7) if (~snaps[s, :, :1] & snaps[s].any(axis=1)[:, None]).any()]
    assert mixed and 3 not in mixed, "the middle shows a change itself"
    s, _, i, j = view.opened
    assert abs(s - 3) == min(abs(one - 3) for one in mixed)
    assert snaps[s, i, j] and not snaps[s, i, :j].any() and j > 0
    assert view.page.input_value("#at-spring") == str(s)


def test_the_page_opens_on_a_reproduced_cell(browser, view, cube, traced, tmp_path):
    """Even if the ones nearest the middle are not."""
    usual = view.opened
    doubted = cube.assign(
        well_share=xr.ones_like(cube.well_share), well_reproduced=xr.ones_like(cube.reproduced)
    )
    doubted.well_reproduced[{"f0": usual[1]}] = 0
    write_text(tmp_path / "page.html", doubted, traced)
    c, i, j = View(browser, tmp_path / "page.html").opened
    assert i != usual[1] and np.isfinite(cube.t_snap.values[c, i, j])
    assert not np.isfinite(cube.t_snap.values[c, i, :j]).any()
