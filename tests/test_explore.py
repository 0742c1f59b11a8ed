"""The traces against histories, and the page in a browser."""

import json
import re
import shutil
from dataclasses import asdict

import numpy as np
import pytest
import xarray as xr
from playwright.sync_api import sync_playwright
from trace_cells import trace_cells
from write_page import write_page

import snapmap
from snapmap import traces
from snapmap.figures.explore import page
from snapmap.figures.maps import WORDS
from snapmap.solver.adaptive import Ladder
from snapmap.solver.simd_kernel import SAMPLE
from snapmap.solver.models import build_model
from snapmap.io.netcdf import write
from snapmap.solver.outcome import OUTCOMES
from snapmap.solver.settings import Protocol

MODEL = {"name": "cosines", "modes": 3}
PROTOCOL = Protocol(horizon=300.0)
AXES = {"C": [0.025, 200.0], "f0": [1000.0, 3000.0, 9000.0], "N": [800.0, 1000.0, 1300.0, 2200.0]}
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)


def swept(device, **changes):
    asked = {**AXES, "model": "cosines", "modes": 3, "horizon": PROTOCOL.horizon, **changes}
    return snapmap.sweep(device, **asked)


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


@pytest.fixture(scope="module")
def packed(handout, cube):
    return traces.trace(handout, cube, MODEL, PROTOCOL, threads=2)


@pytest.fixture(scope="module")
def traced(packed):
    return xr.decode_cf(packed)


def history_of(device, cell):
    """The cell's history at the instants that a trace looks at, and the time between two."""
    run = snapmap.simulate(device, **cell, model="cosines", modes=3, horizon=PROTOCOL.horizon)
    dt = build_model(device, "cosines", modes=3).dt
    assert float(run.time[1]) == pytest.approx(dt), "the history leaves out instants"
    return run.isel(time=slice(None, None, SAMPLE)), SAMPLE * dt


@pytest.mark.parametrize(("N", "f0", "C"), [(800.0, 9000.0, 200.0), (2200.0, 1000.0, 0.025)])
def test_traces_are_the_history(handout, packed, traced, N, f0, C):
    """The band ends at the extremes of each bin, within the rounding, which goes outward."""
    run, look = history_of(handout, {"N": N, "f0": f0, "C": C})
    cell = traced.sel(N=N, f0=f0, C=C)
    per_bin = round(float(cell.bin_length) / look)
    bins = min(cell.sizes["bin"], run.sizes["time"] // per_bin)
    w = run.w_mid.values[: bins * per_bin].reshape(bins, per_bin)
    one = packed.w_low.attrs["scale_factor"]
    below, above = w.min(axis=1) - cell.w_low[:bins], cell.w_high[:bins] - w.max(axis=1)
    for gap in (below, above):
        assert gap.min() > -1e-9 and gap.max() < one + 1e-9

    starts = run.isel(time=slice(0, bins * per_bin, per_bin))
    off = abs(cell.z_mass.values[:bins] - starts.z_mass.values)
    assert off.max() <= 0.5001 * packed.z_mass.attrs["scale_factor"]
    stored = ("kinetic", "spring", "bending", "axial", "contact")
    energy = sum(starts[f"{kind}_energy"] for kind in stored) / run.attrs["barrier"]
    off = abs(cell.energy.values[:bins] - np.minimum(energy.values, traces.ENERGY_REACH))
    assert off.max() <= 0.5001 * packed.energy.attrs["scale_factor"]
    assert (cell.beam_energy <= cell.energy).all()


def test_traces_are_the_sweeps_runs(handout):
    """They snap when the cube says; also where the sweep halved the step."""
    cube = swept(handout, N=np.linspace(600, 2400, 12), f0=np.geomspace(100, 3e4, 12))
    packed = traces.trace(handout, cube, MODEL, PROTOCOL)
    traced, one = xr.decode_cf(packed), packed.w_low.attrs["scale_factor"]
    looks = traced.bin_length / (SAMPLE * build_model(handout, **MODEL).dt)
    assert (abs(looks - looks.round()) > 0.1).any(), "no step was halved"

    snapped, w_2 = cube.t_snap.notnull(), handout.beam.second_equilibrium
    assert ((traced.w_low <= w_2).any("bin") == snapped).all()
    bin_of_snap = np.floor(cube.t_snap / traced.bin_length)
    assert not ((traced.bin < bin_of_snap) & (traced.w_low + one <= w_2)).any()
    soon = traced.bin <= bin_of_snap + 1
    assert ((soon & (traced.w_low <= w_2)).any("bin") == snapped).all()


def test_traces_show_the_proofs(cube, traced):
    """What is proven by all its energy ends below the saddle, and all that is proven is shown."""
    outcome = cube.outcome.copy(data=np.array(OUTCOMES)[cube.outcome.values])
    proven = outcome.isin(["never", "returned"])
    assert proven.any() and (traced.energy.isel(bin=-1) < 1).where(proven, True).all()
    shown = traced.bin_length * traced.sizes["bin"]
    assert (shown >= 1e6 / cube.f0).all() and (shown >= cube.t_settled.fillna(0)).all()


def test_traces_end_where_the_sweep_did(handout):
    """A sweep that ends at the snap has proven its step good enough up to there, not beyond."""
    cube = swept(handout, until="snap")
    traced = traces.trace(handout, cube, MODEL, PROTOCOL._replace(until="snap"))
    shown = (traced.bin_length * traced.sizes["bin"]).where(cube.t_snap.notnull())
    assert shown.notnull().any() and (shown >= cube.t_snap).where(shown.notnull(), True).all()
    look = SAMPLE * build_model(handout, **MODEL).dt * traced.sizes["bin"]
    assert (shown - cube.t_snap).max() <= look


def test_traces_do_not_depend_on_threads_or_order(handout, cube, packed):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    again = traces.trace(handout, mixed, MODEL, PROTOCOL, threads=1)
    xr.testing.assert_equal(again, packed)


def test_a_large_grid_is_thinned_by_whole_strides(cube):
    axes = {"C": np.arange(5.0), "f0": np.arange(1.0, 211), "N": np.arange(301.0)}
    large = xr.Dataset({"outcome": (tuple(axes), np.zeros((5, 210, 301), np.int8))}, axes)
    thinned = traces.thin(large)
    assert np.unique(np.diff(thinned.f0)).size == np.unique(np.diff(thinned.N)).size == 1
    assert thinned.sizes["C"] == 5 and traces.CELLS / 2 < thinned.outcome.size <= traces.CELLS
    assert traces.thin(cube).sizes == cube.sizes


def test_a_failed_cell_has_no_trace_and_spoils_no_range(handout, packed):
    failed = swept(handout, N=[800.0, 2200.0, 1e30], f0=[1000.0], C=[0.025])
    assert failed.outcome.values.ravel()[-1] == OUTCOMES.index("failed")
    found = traces.trace(handout, failed, MODEL, PROTOCOL)
    assert found.w_low.attrs["scale_factor"] <= packed.w_low.attrs["scale_factor"]
    last = xr.decode_cf(found).isel(N=-1)
    assert last.energy.isnull().any() and not last.isel(bin=0).energy.isnull()


def test_a_ladders_cell_is_traced_by_the_level_that_decided(handout, cube, monkeypatch):
    models = [{**MODEL, "step": step} for step in (0.5, 0.3)]
    base, top = (build_model(handout, **model) for model in models)
    monkeypatch.setattr(
        traces,
        "choose_model",
        lambda device, name, **options: (
            Ladder(base, top, top, (0.0, 0.0, 0.0))
            if name == "auto"
            else build_model(device, name, **options)
        ),
    )
    level = (cube.N > 900).astype(np.int8).broadcast_like(cube.outcome)
    found = traces.trace(handout, cube.assign(level=level), {"name": "auto"}, PROTOCOL)
    alone = [traces.trace(handout, cube, model, PROTOCOL).bin_length for model in models]
    assert (alone[0] != alone[1]).any()
    xr.testing.assert_equal(found.bin_length, xr.where(level == 0, *alone))


def test_the_reference_is_traced_by_its_elements_in_modes(handout, cube):
    model = {"name": "reference", "elements": 2}
    as_reference = traces.trace(handout, cube, model, PROTOCOL)
    as_handout = traces.trace(handout, cube, {**model, "name": "handout"}, PROTOCOL)
    xr.testing.assert_equal(as_reference, as_handout)


@pytest.fixture(scope="module")
def page_file(handout, cube, tmp_path_factory):
    """The page of the small cube, made by the rules' own functions."""
    folder = tmp_path_factory.mktemp("a page")
    paths = [folder / name for name in ("cube.nc", "traces.nc", "explore.html")]
    write(cube, paths[0])
    trace_cells(paths[0], asdict(handout), MODEL, PROTOCOL._asdict(), paths[1], threads=1)
    write_page(*paths)
    assert sorted(folder.iterdir()) == sorted(paths)
    return paths[2]


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

    def __init__(self, browser, path):
        self.page, self.requests, self.complaints = browser.new_page(), [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(path.as_uri())
        self.wait("document.getElementById('verdict').textContent")

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
        """Where in the window the cell of the i-th f0 and the j-th N is drawn."""
        return self.page.evaluate(
            """([i, j]) => {
                const { xaxis, yaxis } = map._fullLayout;
                const box = map.querySelector(".nsewdrag").getBoundingClientRect();
                return [box.x + xaxis.d2p(f0[i]), box.y + yaxis.d2p(N[j])];
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
        """Wait until the cell of the i-th f0 and the j-th N is the chosen one."""
        chosen = f"JSON.stringify(chosen) === '[{i},{j}]'"
        self.wait(chosen)

    def slide(self, index):
        self.page.fill("#slider", str(index))


@pytest.fixture(scope="module")
def view(browser, page_file):
    return View(browser, page_file)


def codes_of(cube, c):
    return cube.outcome.isel(C=c).transpose("N", "f0").values.tolist()


def test_the_page_loads_alone_and_without_complaint(browser, page_file):
    view = View(browser, page_file)
    view.click(0, 3)
    view.slide(1)
    view.page.set_viewport_size({"width": 420, "height": 800})
    view.wait("document.documentElement.scrollWidth <= 420")
    assert view.requests == [page_file.as_uri()]
    assert view.complaints == []


def test_no_button_sends_the_study_anywhere(browser, page_file):
    view = View(browser, page_file)
    buttons = view.page.query_selector_all(".modebar-btn")
    titles = [button.get_attribute("data-title") for button in buttons]
    assert len(titles) > 4 and not [title for title in titles if re.search("hare|loud|dit", title)]
    for button in buttons:
        button.evaluate("button => button.click()")
    assert not [url for url in view.requests if not url.startswith(("file:", "blob:", "data:"))]


def test_what_a_page_is_made_to_ask_for_is_refused(browser, page_file):
    view = View(browser, page_file)
    asked = "fetch('https://example.org/').then(() => 'sent', () => 'refused')"
    assert view.page.evaluate(asked) == "refused"
    assert any("Content Security Policy" in complaint for complaint in view.complaints)


def test_the_slider_changes_the_map(view, cube):
    assert codes_of(cube, 0) != codes_of(cube, 1)
    for c, words in enumerate(("C = 0.025 µN µs/µm", "C = 200 µN µs/µm")):
        view.slide(c)
        assert view.shown("map", "z") == codes_of(cube, c)
        assert view.text("#C") == words
        apart = (cube.reproduced.isel(C=c) == 0).sum()
        assert len(view.shown("map", "x", curve=1)) == apart


def test_the_classes_are_named_and_counted(view, cube):
    view.slide(0)
    counts = np.bincount(cube.outcome.isel(C=0).values.ravel(), minlength=len(OUTCOMES))
    for name, count in zip(OUTCOMES, counts, strict=True):
        assert (f"{WORDS[name]} ({count})" in view.text("#classes")) == (count > 0)


def test_a_cell_says_what_it_is_under_the_pointer(view, cube):
    view.slide(1)
    i, j = np.argwhere(np.isfinite(cube.t_snap.isel(C=1).values))[0]
    cell = cube.isel(C=1, f0=i, N=j)
    words = WORDS[OUTCOMES[int(cell.outcome)]]
    time = f"{float(cell.t_snap):.4g}"
    expected = [words, f"N = {cell.N:g}", f"f0 = {cell.f0:g} Hz", f"tsnap = {time} µs"]
    text = view.hover(int(i), int(j))
    assert all(part in text for part in expected), text


def test_a_click_shows_the_history_of_that_cell(view, packed):
    view.slide(0)
    for i, j in ((0, 3), (2, 0)):
        view.click(i, j)
        cell = packed.isel(C=0, f0=i, N=j)
        for curve, key in enumerate(("w_low", "w_high", "z_mass", "energy", "beam_energy")):
            expected = xr.decode_cf(cell)[key].values
            assert view.shown("history", "y", curve) == pytest.approx(expected.tolist())
        starts = float(cell.bin_length) / 1e3 * np.arange(cell.sizes["bin"])
        assert view.shown("history", "x", 2) == pytest.approx(starts.tolist())
        assert view.text("#cell").startswith(f"N = {cell.N:g}, f0 = {cell.f0:g} Hz")


def test_the_arrow_keys_move_the_choice(view):
    view.click(1, 1)
    view.page.focus("#keys")
    for key, cell in (("Right", (2, 1)), ("Right", (2, 1)), ("Up", (2, 2)), ("Left", (1, 2))):
        view.page.keyboard.press(f"Arrow{key}")
        view.wait_for(*cell)


def test_a_sentence_says_how_the_label_is_known(view, cube):
    for c, i, j in np.ndindex(cube.outcome.shape):
        name = OUTCOMES[int(cube.outcome[c, i, j])]
        view.page.evaluate(f"slider.value = {c}; choose({i}, {j})")
        text, cell = view.text("#verdict"), cube.isel(C=c, f0=i, N=j)
        assert text.startswith(WORDS[name])
        for key, known in (("t_snap", "reached the second"), ("t_settled", "proven")):
            seen = bool(np.isfinite(cell[key]))
            assert (known in text) == seen
            assert not seen or f"t = {float(cell[key]):.4g} µs" in text
        assert ("open" in text) == (name in ("snapped", "unsnapped"))


def large_study(cube, packed):
    """A cube of 50 000 cells and traces that compress as badly as real ones, about by half."""
    rng = np.random.default_rng(3)
    axes = {"C": 5, "f0": 100, "N": 100}
    values = {key: np.arange(1.0, size + 1) for key, size in axes.items()}
    code = rng.integers(0, len(OUTCOMES), tuple(axes.values()), np.int8)
    t_snap = rng.uniform(10, 1000, code.shape)
    large = xr.Dataset(
        {
            "outcome": (tuple(axes), code, cube.outcome.attrs),
            "t_snap": (tuple(axes), t_snap),
            "t_settled": (tuple(axes), t_snap),
        },
        values,
        cube.attrs,
    )
    noise = rng.integers(100, 116, (traces.BINS[0], *code.shape), np.uint8)
    kept = {key: (("bin", *axes), noise, packed[key].attrs) for key in traces.VARIABLES}
    kept["bin_length"] = (tuple(axes), np.ones(code.shape, np.float32))
    return large, xr.Dataset(kept, values, packed.attrs)


def test_a_page_of_50_000_cells_is_small_and_answers(browser, cube, packed, tmp_path):
    path = tmp_path / "large.html"
    path.write_text(page(*large_study(cube, packed)), encoding="utf-8")
    assert path.stat().st_size < 15e6
    view = View(browser, path)
    before = view.shown("history", "y", 2)
    view.click(10, 20)
    assert view.shown("history", "y", 2) != before
    before = view.shown("map", "z")
    view.slide(4)
    assert view.shown("map", "z") != before
    assert view.complaints == []


def test_a_thinned_page_says_so(cube, packed):
    some = packed.isel(N=slice(None, None, 2))
    assert "Shown are 3 of 3 f0 and 2 of 4 N of the cube." in page(cube, some)
    assert "Shown are" not in page(cube, packed)


def test_text_from_a_config_is_text(cube, packed):
    document = json.loads(cube.attrs["config"])
    document["model"]["name"] = "<b>bold</b>"
    text = page(cube.assign_attrs(config=json.dumps(document)), packed)
    assert "&lt;b&gt;bold" in text and "<b>bold</b>" not in text
