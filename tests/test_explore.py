"""The traces against histories, and the page in a browser."""

import json
import re
import shutil
from dataclasses import asdict, replace

import numpy as np
import pytest
import xarray as xr
from playwright.sync_api import sync_playwright
from trace_cells import trace_cells
from write_page import write_page

import snapmap
from snapmap.figures.explore import NO_HATCH, page
from snapmap.figures.maps import WORDS
from snapmap.io.netcdf import write
from snapmap.motion import envelopes
from snapmap.solver.adaptive import Adaptive
from snapmap.solver.models import build_model
from snapmap.solver.outcome import ABSENT, OUTCOMES
from snapmap.solver.schemes import EXPLICIT, SCHEMES
from snapmap.solver.settings import Settings
from snapmap.solver.simd_kernel import SAMPLE

MODEL = {"name": "cosines", "modes": 3}
SETTINGS = Settings(horizon=300.0)
AXES = {"C": [0.025, 200.0], "f0": [1000.0, 3000.0, 9000.0], "N": [800.0, 1000.0, 1300.0, 2200.0]}
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)


def swept(device, **changes):
    asked = {**AXES, "model": "cosines", "modes": 3, "horizon": SETTINGS.horizon, **changes}
    return snapmap.sweep(device, **asked)


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


@pytest.fixture(scope="module")
def packed(handout, cube):
    return envelopes.trace(handout, cube, MODEL, SETTINGS._replace(threads=2))


@pytest.fixture(scope="module")
def traced(packed):
    return xr.decode_cf(packed)


def history_of(device, cell):
    """The cell's history at the steps that a trace looks at, and the time between two looks."""
    run = snapmap.simulate(device, **cell, model="cosines", modes=3, horizon=SETTINGS.horizon)
    dt = build_model(device, "cosines", modes=3).dt
    assert float(run.time[1] - run.time[0]) == pytest.approx(dt), "the history leaves out steps"
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
    off = abs(cell.energy.values[:bins] - np.minimum(energy.values, envelopes.ENERGY_REACH))
    assert off.max() <= 0.5001 * packed.energy.attrs["scale_factor"]
    assert (cell.beam_energy <= cell.energy).all()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_traces_are_the_sweeps_runs(handout, scheme):
    """They snap when the cube says; also where the sweep halved the step."""
    N, f0, model = (
        np.linspace(600, 2400, 12),
        np.geomspace(100, 3e4, 12),
        MODEL | {"scheme": scheme},
    )
    cube = swept(handout, N=N, f0=f0, scheme=scheme)
    packed = envelopes.trace(handout, cube, model, SETTINGS)
    traced, one = xr.decode_cf(packed), packed.w_low.attrs["scale_factor"]
    looks = traced.bin_length / (SAMPLE * build_model(handout, **model).dt)
    halved = abs(looks - looks.round()) > 0.1
    assert halved.any() == (scheme == EXPLICIT), "what is tested is not there"

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
    traced = envelopes.trace(handout, cube, MODEL, SETTINGS._replace(until="snap"))
    shown = (traced.bin_length * traced.sizes["bin"]).where(cube.t_snap.notnull())
    assert shown.notnull().any() and (shown >= cube.t_snap).where(shown.notnull(), True).all()
    look = SAMPLE * build_model(handout, **MODEL).dt * traced.sizes["bin"]
    assert (shown - cube.t_snap).max() <= look


def test_traces_do_not_depend_on_threads_or_order(handout, cube, packed):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    again = envelopes.trace(handout, mixed, MODEL, SETTINGS)
    xr.testing.assert_equal(again, packed)


def test_a_large_grid_is_thinned_by_whole_strides(cube):
    axes = {"C": np.arange(5.0), "f0": np.arange(1.0, 211), "N": np.arange(301.0)}
    large = xr.Dataset({"outcome": (tuple(axes), np.zeros((5, 210, 301), np.int8))}, axes)
    thinned = envelopes.thin(large)
    assert np.unique(np.diff(thinned.f0)).size == np.unique(np.diff(thinned.N)).size == 1
    assert thinned.sizes["C"] == 5 and envelopes.CELLS / 2 < thinned.outcome.size <= envelopes.CELLS
    assert envelopes.thin(cube).sizes == cube.sizes


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_failed_cell_spoils_no_range(handout, packed, scheme):
    """What blew up has no trace; the conserving scheme stays finite, and is wrong."""
    failed = swept(handout, N=[800.0, 2200.0, 1e30], f0=[1000.0], C=[0.025], scheme=scheme)
    assert failed.outcome.values.ravel()[-1] == OUTCOMES.index("failed")
    found = envelopes.trace(handout, failed, MODEL | {"scheme": scheme}, SETTINGS)
    assert found.w_low.attrs["scale_factor"] <= packed.w_low.attrs["scale_factor"]
    last = xr.decode_cf(found).isel(N=-1)
    assert not last.isel(bin=0).energy.isnull()
    assert last.energy.isnull().any() == (scheme == EXPLICIT)


def test_an_adaptive_cell_is_traced_by_the_level_that_decided(handout, cube, monkeypatch):
    models = [{**MODEL, "step": step} for step in (0.5, 0.3)]

    def choose_model(device, model, threads):
        base, top = (build_model(device, **one) for one in models)
        is_auto = model["name"] == "auto"
        return Adaptive(base, top, top, np.zeros(3)) if is_auto else build_model(device, **model)

    monkeypatch.setattr(envelopes, "choose_model", choose_model)
    level = (cube.N > 900).astype(np.int8).broadcast_like(cube.outcome)
    found = envelopes.trace(handout, cube.assign(level=level), {"name": "auto"}, SETTINGS)
    alone = [envelopes.trace(handout, cube, model, SETTINGS).bin_length for model in models]
    assert (alone[0] != alone[1]).any()
    xr.testing.assert_equal(found.bin_length, xr.where(level == 0, *alone))


def test_devices_are_traced_as_each_alone(handout):
    """Also those of two kinds of model, with a contact that is hard and one that is not."""
    model = {**MODEL, "cosines": 4}
    asked = {**AXES, **model, "model": model["name"], "horizon": SETTINGS.horizon}
    del asked["name"]
    points = {"thickness": [1.8, 4.4], "contact": [40.0, np.inf]}
    cube = snapmap.sweep(handout, **asked, **points, skip=True)
    traced = xr.decode_cf(envelopes.trace(handout, cube, model, SETTINGS))
    assert traced.second_equilibrium.dims == ("thickness", "contact")
    for contact in points["contact"]:
        thin = replace(handout.beam, thickness=1.8)
        device = replace(handout, beam=thin, contact=contact)
        own = snapmap.sweep(device, **asked)
        alone = xr.decode_cf(envelopes.trace(device, own, model, SETTINGS))
        there = traced.sel(thickness=1.8, contact=contact)
        assert float(there.second_equilibrium) == device.beam.second_equilibrium
        np.testing.assert_array_equal(there.bin_length, alone.bin_length)
        # Both round outward, each by the steps of its own range.
        step = sum(abs(one.w_low.max() - one.w_low.min()).item() for one in (there, alone)) / 254
        assert abs(there.w_low - alone.w_low).max() <= 2 * step
        np.testing.assert_allclose(there.energy, alone.energy)
    absent = traced.sel(thickness=4.4)
    assert absent.energy.isnull().all() and absent.second_equilibrium.isnull().all()


def test_what_follows_the_horizon_spoils_no_range(handout, cube, monkeypatch):
    """Bins go on beyond it, where a run that was believed may blow up."""
    usual, follow = envelopes.trace(handout, cube, MODEL, SETTINGS), envelopes._follow

    def blow_up(model, pulses, cells, window, bins, threads):
        values, bin_length = follow(model, pulses, cells, window, bins, threads)
        begins = np.arange(bins)[:, np.newaxis] * bin_length
        values[:, begins > window] = 1e280
        assert (begins > window).any()
        return values, bin_length

    monkeypatch.setattr(envelopes, "_follow", blow_up)
    found = envelopes.trace(handout, cube, MODEL, SETTINGS)
    assert found.w_low.attrs["scale_factor"] == usual.w_low.attrs["scale_factor"]


def test_the_reference_is_traced_by_its_elements_in_modes(handout, cube):
    model = {"name": "reference", "elements": 2}
    as_reference = envelopes.trace(handout, cube, model, SETTINGS)
    as_handout = envelopes.trace(handout, cube, {**model, "name": "handout"}, SETTINGS)
    xr.testing.assert_equal(as_reference, as_handout)


@pytest.fixture(scope="module")
def page_file(handout, cube, tmp_path_factory):
    """The page of the small cube, made by the rules' own functions."""
    folder = tmp_path_factory.mktemp("a page")
    paths = [folder / name for name in ("cube.nc", "traces.nc", "explore.html")]
    write(cube, paths[0])
    trace_cells(paths[0], asdict(handout), {}, MODEL, SETTINGS.asked(), paths[1], threads=1)
    write_page(paths[0], paths[1], SETTINGS.horizon, paths[2])
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

    def sliders(self):
        """The label and the value of each slider."""
        rows = "[...document.querySelectorAll('#sliders input')].map((slider) => ["
        rows += "slider.labels[0].textContent, slider.nextElementSibling.textContent])"
        return [[text.replace("\xa0", " ") for text in row] for row in self.page.evaluate(rows)]

    def place(self):
        """Where the chosen cell is on each axis."""
        return self.page.evaluate("at")


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
    for c, words in enumerate(("0.025 µN µs/µm", "200 µN µs/µm")):
        view.slide(c)
        assert view.shown("map", "z") == codes_of(cube, c)
        assert view.sliders() == [["damping of the mass C", words]]
        assert view.page.get_attribute("#at-C", "aria-valuetext").replace("\xa0", " ") == words
        assert f"C = {words}" in view.text("#cell")
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
        view.page.evaluate(f"at[0] = {c}; choose({i}, {j})")
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
    code = rng.integers(0, ABSENT, tuple(axes.values()), np.int8)
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
    noise = rng.integers(100, 116, (envelopes.BINS[0], *code.shape), np.uint8)
    kept = {key: (("bin", *axes), noise, packed[key].attrs) for key in envelopes.VARIABLES}
    kept["bin_length"] = (tuple(axes), np.ones(code.shape, np.float32))
    kept["second_equilibrium"] = packed.second_equilibrium
    return large, xr.Dataset(kept, values, packed.attrs)


def test_a_page_of_50_000_cells_is_small_and_answers(browser, cube, packed, tmp_path):
    path = tmp_path / "large.html"
    path.write_text(page(*large_study(cube, packed), SETTINGS.horizon), encoding="utf-8")
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
    assert "Shown are 2 of 4 N of the cube." in page(cube, some, 300.0)
    fewer = some.isel(C=[0], f0=slice(None, None, 2))
    assert "Shown are 1 of 2 C, 2 of 3 f0 and 2 of 4 N of the cube." in page(cube, fewer, 300.0)
    assert "Shown are" not in page(cube, packed, 300.0)


def test_text_from_a_config_is_text(cube, packed):
    document = json.loads(cube.attrs["config"])
    document["model"]["name"] = "<b>bold</b>"
    text = page(cube.assign_attrs(config=json.dumps(document)), packed, SETTINGS.horizon)
    assert "&lt;b&gt;bold" in text and "<b>bold</b>" not in text


def view_of(browser, path, device, **asked):
    """The cube of a device, or of several, and its page in a browser."""
    cube = swept(device, **asked)
    model = json.loads(cube.attrs["config"])["model"]
    traces = envelopes.trace(device, cube, model, SETTINGS)
    path.write_text(page(cube, traces, SETTINGS.horizon), encoding="utf-8")
    return cube, View(browser, path)


def shows(view, cells, x, y):
    """Whether the map is that of some cells, and of the axes x and y."""
    codes = cells.outcome.transpose(y, x).values.tolist()
    return view.shown("map", "z") == codes


@pytest.fixture(scope="module")
def of_devices(browser, handout, tmp_path_factory):
    """Two axes of the device, one of which has points without a second stable shape."""
    path = tmp_path_factory.mktemp("devices") / "explore.html"
    axes = {"C": [25.0], "thickness": [1.8, 2.0, 4.4], "spring": [4.0, 7.0]}
    return view_of(browser, path, handout, **axes, skip=True)


def test_each_further_axis_of_several_values_has_a_slider(of_devices):
    cube, view = of_devices
    maps = set()
    for t, s in np.ndindex(3, 2):
        view.slide(t, "thickness")
        view.slide(s, "spring")
        cells = cube.isel(thickness=t, spring=s, C=0)
        assert shows(view, cells, "f0", "N")
        maps.add(cells.outcome.values.tobytes())
        values = [f"{cells.thickness:g} µm", f"{cells.spring:g} N/m"]
        assert view.sliders() == [["thickness", values[0]], ["spring", values[1]]]
        assert view.page.get_attribute("#at-spring", "aria-valuetext") == values[1].replace(
            " ", "\xa0"
        )
        heading = f"C = 25 µN µs/µm, spring = {values[1]}, thickness = {values[0]}"
        assert view.text("#cell").endswith(heading)
    assert len(maps) == 5, "the maps of some devices are alike"
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
    assert colours[-1][1] == NO_HATCH["absent"]
    hovered = view.hover(0, 0)
    assert words in hovered and "snap =" not in hovered and "no snap" not in hovered
    view.slide(0, "thickness")
    assert view.page.is_visible("#history") and view.shown("history", "y", 2)[0] is not None
    assert view.complaints == []


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
    titles = view.page.evaluate("[map.layout.xaxis.title.text, map.layout.yaxis.title.text]")
    assert any("thickness (µm)" in title for title in titles)


def test_a_cell_alone_is_a_page(browser, handout, tmp_path):
    asked = {"N": [1000.0], "f0": [1500.0], "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **asked)
    assert shows(view, cube.isel(C=0), "f0", "N") and view.sliders() == []
    assert view.text("#cell") == "N = 1000, f0 = 1500 Hz, C = 25 µN µs/µm"


def test_the_page_opens_at_a_change_of_label_near_the_middle(browser, handout, tmp_path):
    """The middle spring snaps everywhere or nowhere, so that another has to be shown."""
    springs = [1.0, 4.0, 7.0, 500.0, 600.0, 700.0, 800.0]
    axes = {"spring": springs, "N": np.linspace(600, 2400, 9), "C": [25.0]}
    cube, view = view_of(browser, tmp_path / "page.html", handout, **axes)
    snaps = np.isfinite(cube.t_snap.values[:, 0])
    mixed = [s for s in range(7) if snaps[s].any() and not snaps[s].all()]
    assert mixed and 3 not in mixed, "the middle shows a change itself"
    s, _, i, j = view.place()
    assert abs(s - 3) == min(abs(one - 3) for one in mixed)
    beside = [
        snaps[s, a, b]
        for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
        if 0 <= a < 3 and 0 <= b < 9
    ]
    assert snaps[s, i, j] and not all(beside)
    assert view.page.input_value("#at-spring") == str(s)
