"""What the page holds of a study, and the page in a browser."""

import json
import re
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread
from small_results import SETTINGS, make_cells, make_verdict, swept
from small_studies import cases_of

from snapmap.applications.page import application
from snapmap.applications.page.figure import GREY, _opening, page
from snapmap.applications.requirements.verdict import write_verdicts
from snapmap.applications.whole import load_config
from snapmap.figures.states import ABSENT, ELSEWHERE, SNAPS, STATES, end_states, snap_states
from snapmap.solver.outcome import OUTCOMES
from snapmap.solver.settings import Run
from snapmap.study.variables import write

ALWAYS, FIRST, _, CHOSEN, POINTS = range(1, 6)
"""Which curve of the map is which."""
POINT_AT, COLOURS = (
    Path(__file__).with_name(f"{name}.js").read_text(encoding="utf-8")
    for name in ("point_at", "colours")
)


CRASH = {"requirement": "crash", "must_snap": True, "margin": 0.5}
VERDICTS = (
    make_verdict(**CRASH, verdict="unclear", end="ends differ", share_staying=0.4),
    make_verdict(**CRASH, C=50.0, end="stays", share_staying=1.0),
)
"""Of which the page tells the worst."""


@pytest.fixture(scope="module")
def cube(handout):
    return swept(handout)


def edges_of(cube):
    """Thresholds of a cube, read off its grid: what the page needs of threshold.nc."""
    first = cube.N.where(cube.t_snap.notnull()).min("N")
    variables = {"N_first": first, "N_error": 0 * first + 20, "N_always": first + 50}
    return xr.Dataset(variables, attrs=cube.attrs)


REQUIRED = [
    ("crash", 3000.0, 1200.0, [("versed sine", "+z")]),
    ("<i>drop</i>", 9e4, 900.0, [("versed sine", "+z"), ("half sine", "+z")]),
    ("another's", 3000.0, 1200.0, [("half sine", "+z")]),
]


def shown_of(cube, **more):
    """What the page shows beside a cube."""
    config = json.loads(cube.attrs["config"])
    written = config.get("devices") or {"device": config["device"]}
    shown = {"written": written, "horizon": SETTINGS.horizon}
    return shown | {"title": "", "pulse": {}, "required": (), "own_points": []} | more


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("a page")


@pytest.fixture(scope="module")
def page_text(cube, folder):
    """The page of the small cube, written by the rule's own function."""
    files = {name: folder / f"{name}.nc" for name in ("cube", "threshold")}
    for dataset, path in zip((cube, edges_of(cube)), files.values(), strict=True):
        write(dataset, path)
    files["requirements"] = folder / "requirements.csv"
    write_verdicts(VERDICTS, files["requirements"], "uN*us/um")
    points = folder / "shots.csv"
    points.write_text("name,N,f0 (Hz),snapped\na,1200,3000,yes\nb,900,1500,no\n")
    drawing = shown_of(cube, title="Crash sensor A", required=REQUIRED, own_points=[str(points)])
    application.draw({"explore": drawing}, folder, files)
    assert sorted(folder.iterdir()) == sorted([*files.values(), points, folder / "explore.html"])
    return (folder / "explore.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def show(browser, folder):
    """A function that opens the page of a cube, or a text, in one place: scripts are kept by it."""

    def shown(made, window=browser, scheme="light", **more):
        path = folder / "explore.html"
        if not isinstance(made, str):
            made = page(made, edges_of(made), shown_of(made, **more))
        path.write_text(made, encoding="utf-8")
        return View(window, path, scheme)

    return shown


class View:
    """A page in a browser, what it asked for and what it complained of."""

    def __init__(self, window, path, scheme):
        self.page, self.requests, self.complaints = window.new_page(), [], []
        self.page.emulate_media(color_scheme=scheme)
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(path.as_uri())
        self.wait("document.getElementById('verdict').textContent")

    def wait(self, condition, act=lambda: None):
        """Act, every two seconds, until it holds; the page forbids Playwright's own way to wait."""
        for turn in range(3000):
            if turn % 100 == 0:
                act()
            if self.page.evaluate(condition):
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(condition)

    def text(self, selector):
        return self.page.text_content(selector).replace("\u200b", "").replace("\xa0", " ")

    def shown(self, figure, key, curve=0):
        """What a curve of a figure shows, as plain lists."""
        return self.page.evaluate(
            f"JSON.parse(JSON.stringify(document.getElementById('{figure}').data[{curve}].{key}))"
        )

    def point_at(self, i, j):
        """Where in the window the cell of the i-th x and the j-th y is drawn."""
        return self.page.evaluate(POINT_AT, [i, j])

    def hover(self, i, j):
        """What the page says of a cell; a map that is just drawn anew may miss the pointer."""

        def move(*places):
            for place in places:
                self.page.mouse.move(*place)

        self.page.bring_to_front()
        text, there = "document.getElementById('hovered').textContent", self.point_at(i, j)
        self.wait(f"{text} === ''", lambda: move(there, (0, 0)))
        self.wait(f"{text} !== ''", lambda: move((0, 0), there))
        return self.text("#hovered")

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
        rows = "[...document.querySelectorAll('#sliders input, #at-C')].map((slider) => ["
        rows += "slider.labels[0].textContent, slider.nextElementSibling.textContent])"
        return [[text.replace("\xa0", " ") for text in row] for row in self.page.evaluate(rows)]

    def place(self):
        """Where the chosen cell is on each axis."""
        return self.page.evaluate("at")

    def shows(self, cells, x="f0", y="N", states=snap_states):
        """Whether the map is that of some cells, and of the axes x and y."""
        return self.shown("map", "z") == states(cells).transpose(y, x).values.tolist()


def times(text):
    """The times in a text, us."""
    return re.findall(r"t = ([\d.]+) µs", text)


@pytest.fixture(scope="module")
def view(show, page_text):
    return show(page_text)


@pytest.mark.parametrize("sure", [0, 1])
def test_a_page_opens_at_the_threshold_on_a_cell_that_ends_alike_in_other_steps(sure):
    cells = make_cells(["22", "22", "00"])
    cells["well_reproduced"] = xr.zeros_like(cells.outcome)
    cells.well_reproduced[sure] = 1
    assert _opening(cells, "N") == [sure, 1]


def test_the_page_is_alone_and_sends_the_study_nowhere(show, page_text, folder):
    view = show(page_text)
    view.click(0, 3)
    view.slide(1)
    assert view.requests == [(folder / "explore.html").as_uri()]
    buttons = view.page.query_selector_all(".modebar-btn")
    titles = {button.get_attribute("data-title") for button in buttons}
    assert titles == {"Download plot as a PNG", "Reset axes"}
    for button in buttons:
        button.evaluate("button => button.click()")
    assert all(url.startswith(("file:", "blob:", "data:")) for url in view.requests)
    assert view.complaints == []
    request = "fetch('https://example.org/').then(() => 'sent', () => 'refused')"
    assert view.page.evaluate(request) == "refused"
    assert any("Content Security Policy" in complaint for complaint in view.complaints)


def test_the_slider_changes_map_classes_and_thresholds(view, cube):
    edges, states = edges_of(cube), snap_states(cube)
    assert not states.isel(C=0).equals(states.isel(C=1))
    for c, words in enumerate(("0.025 µN µs/µm", "200 µN µs/µm")):
        view.slide(c)
        assert view.shows(cube.isel(C=c)) and view.sliders()[0][1:] == [words]
        for code, state in enumerate(SNAPS):
            count = int((states.isel(C=c) == code).sum())
            assert (f"{state.words} ({count})" in view.text("#classes")) == (count > 0)
        row = edges.isel(C=c)
        for curve, N in ((FIRST, row.N_first), (ALWAYS, row.N_always)):
            assert view.shown("map", "x", curve) == cube.f0.values.tolist()
            assert view.shown("map", "y", curve) == pytest.approx(N.values.tolist())
        assert view.shown("map", "error_y.array", FIRST) == [20] * cube.f0.size
        view.click(1, 0)
        first, always = row.N_first.values[1], row.N_always.values[1]
        assert f"{first:g} ± 20; above {always:g} all snap" in view.text("#edge")


def test_a_switch_shows_where_cells_end(view, cube):
    """Lines are those of snapping."""
    view.slide(0)
    cells = cube.isel(C=0).transpose("N", "f0")
    view.choose("where it ends")
    assert view.shows(cells, states=end_states) and not any(view.shown("map", "y", FIRST))
    apart = np.argwhere((end_states(cells) == ELSEWHERE).values)
    assert f"{STATES[ELSEWHERE].words} ({len(apart)})" in view.text("#classes")
    j, i = apart[0].tolist()
    assert view.hover(i, j).startswith(STATES[ELSEWHERE].words)
    view.choose("snaps")
    assert view.shows(cells) and any(view.shown("map", "y", FIRST))


def test_the_page_has_the_title_the_required_shocks_of_the_map_and_own_points(view):
    """Shocks of its pulse alone, by numbers beside their places; one beyond is at the edge."""
    assert view.page.title() == view.text("h1") == "Crash sensor A"
    notes = view.page.evaluate("map.layout.annotations.map(({ text, x, y }) => [text, x, y])")
    edge = view.page.evaluate("axes[X].edges.at(-1)")
    at = [["1", 3000, 1200], ["2", edge, 900]]
    assert notes == [
        [text, pytest.approx(np.log10(x)), pytest.approx(np.log10(y))] for text, x, y in at
    ]
    legend = view.text("#classes")
    told = "unclear: ends differ, 40 % of the runs stay, at worst (half sine +z, 1 ms, C = 25,"
    assert f"1: required shock crash, N = 1200, 3000 Hz; {told}" in legend
    assert "another" not in legend
    assert "2: required shock <i>drop</i>, N = 900, 90000 Hz (beyond the map)" in legend
    shown = [view.shown("map", key, POINTS) for key in ("x", "y", "marker.color")]
    assert shown == [[3000, 1500], [1200, 900], ["black", "white"]]
    assert legend.endswith("own point, trippedown point, not tripped")


def test_a_click_and_the_sliders_choose_a_shock_that_the_page_follows(view, cube):
    """At a cell the map tells of it, too; between cells values are between those of the cells."""
    view.click(1, 3)
    view.wait("run")
    cell = cube.isel(f0=1, N=3, C=view.place()[0])
    assert view.page.evaluate("run.snap") == pytest.approx(cell.t_snap.item(), rel=0.02)
    assert times(view.text("#verdict"))[0] == times(view.hover(1, 3))[0] == f"{cell.t_snap:.4g}"
    # Of the same snap the page has another time, which it does not tell.
    assert times(view.text("#followed")) == []
    assert view.page.evaluate("motion.layout.shapes[3].x0") == pytest.approx(cell.t_snap / 1e3)
    w, first = view.shown("history", "y", 1), view.page.evaluate("run.form.first")
    assert w[0] == pytest.approx(first, abs=1e-3) and min(w) < -first / 2
    assert view.page.evaluate("run.form.kappa.length") == 5
    end = min(1e6 / cell.f0.item() + SETTINGS.horizon, 1.2 * cell.t_settled.fillna(np.inf).item())
    assert 1e3 * view.shown("history", "x", 1)[-1] == pytest.approx(end, rel=0.01)
    view.page.focus("#at-N")
    view.page.keyboard.press("ArrowLeft")
    view.wait("run && at[Y] === 2.95")
    assert view.text("#verdict").startswith("between cells:") and view.text("#edge") == ""
    assert times(view.text("#followed"))[0] == view.page.evaluate("round(run.snap)")
    N = 1300**0.05 * 2200**0.95  # on the axis of the map, whose N are spaced by factors
    assert view.text("#at-N + output") == f"{N:.4g}"
    assert view.shown("map", "y", CHOSEN) == pytest.approx([N])
    view.page.keyboard.press("ArrowUp")
    view.wait("run && Number.isInteger(at[Y])")
    assert view.text("#at-N + output") == "2200"


def test_where_the_page_ends_otherwise_it_says_so_and_pictures_the_start(show, cube):
    """It has no time beside that of the map, which counts."""
    other = cube.copy(deep=True)
    other.t_snap[:], other.outcome[:] = np.nan, OUTCOMES.index("unsnapped")
    view = show(other)
    view.click(1, 3)
    view.wait("run")
    assert "It ends otherwise: it snaps" in view.text("#followed b")
    assert times(view.text("#followed")) == [] and view.page.input_value("#instant") == "0"
    view.click(1, 0)
    view.wait("run")
    assert "otherwise" not in view.text("#followed") and view.page.input_value("#instant") == "1"


def test_the_device_is_told_in_the_words_of_its_config(show):
    """With the values that C or an axis has at the cell."""
    document = cases_of(__file__)
    study = load_config(document)
    cube = swept(study.device, **study.axes)
    written = application.figures(study)["explore"]["written"]
    view = show(cube, written=written)
    view.slide(0, "thickness")
    told = view.text("#values")
    for words in ("L0.6 mm", "t1.9 µm", "M10 µg", "factor of the beam200", "9.81 m/s²"):
        assert words in told
    assert "1/µs" not in told


def test_the_picture_moves_with_the_time(view):
    view.click(1, 3)
    view.wait("run")
    beams = set()
    for share in ("0", "1"):
        view.page.fill("#instant", share)
        beams.add(view.page.get_attribute("#beam", "d"))
    assert len(beams) == 2 and view.page.get_attribute("#mass", "d").startswith("M150")
    for there in ("Number(instant.value) > 0.01", "instant.value === '1'"):
        view.page.evaluate("drawScene(0)")
        view.page.click("#play")
        assert view.text("#play") == "stop"
        view.wait(there)
        view.page.evaluate("document.getElementById('play').textContent === 'stop' && play.click()")
        assert view.text("#play") == "play"


def test_keys_move_the_choice(view):
    view.click(1, 1)
    view.page.focus("#keys")
    for key, cell in (("Right", (2, 1)), ("Right", (2, 1)), ("Up", (2, 2)), ("Left", (1, 2))):
        view.page.keyboard.press(f"Arrow{key}")
        view.wait_for(*cell)


def test_the_first_keys_skip_to_the_parts_of_the_page(show, page_text):
    view = show(page_text)
    for name in ("map", "shock"):
        view.page.keyboard.press("Tab")
        assert view.page.evaluate("document.activeElement.textContent") == name
    view.page.keyboard.press("Enter")
    assert view.page.evaluate("document.activeElement.id") == "cell"
    view.page.keyboard.press("Tab")
    assert view.page.evaluate("document.activeElement.id") == "at-N"


GROUND = "getComputedStyle(document.body).backgroundColor"


def luminance(colour):
    """The relative luminance of WCAG 2; colour: as of a computed style, or (..., 3) in 0 to 1."""
    if isinstance(colour, str):
        colour = np.array([float(part) for part in re.findall(r"[\d.]+", colour)[:3]]) / 255
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def pixels(view, selector):
    """Luminance of the pixels of a part of a page, ascending."""
    view.page.wait_for_timeout(200)
    image = imread(BytesIO(view.page.locator(selector).screenshot()))
    return np.sort(luminance(image[..., :3]).ravel())


@pytest.fixture(scope="module", params=["light", "dark"])
def schemed(request, show, page_text):
    """A scheme of colours, and the page in it."""
    view = show(page_text, scheme=request.param)
    view.wait("run")
    return request.param, view


def test_texts_stand_out_in_light_and_dark(schemed):
    """Figures are turned with the page; of the map the cells keep their colours."""
    scheme, view = schemed
    pairs = {tuple(pair) for pair in view.page.evaluate(COLOURS)}
    text, ground = np.array([[*map(luminance, pair)] for pair in pairs]).T
    assert len(pairs) > 3 and ((text < ground) == (scheme == "light")).all()
    low, high = np.minimum(text, ground), np.maximum(text, ground)
    assert ((high + 0.05) / (low + 0.05)).min() >= 4.5, pairs
    for part in ("#history", "figure svg", "#scene"):
        shown = pixels(view, part)
        middle, ends = np.median(shown), (shown[0] + 0.05, shown[-1] + 0.05)
        assert middle == pytest.approx(luminance(view.page.evaluate(GROUND)), abs=0.01)
        assert ends[1] / ends[0] > 4.5
    assert view.shown("map", "colorscale")[0][1] == SNAPS[0].colour and view.complaints == []


A4 = {"width": 703, "height": 1032}
"""A sheet within margins of 12 mm, in pixels of CSS."""


def test_the_print_is_light_and_keeps_the_key_with_its_map(schemed):
    scheme, view = schemed
    sheets = re.findall(rb"/Type\s*/Page\b", view.page.pdf(format="A4"))
    assert len(sheets) <= 3
    view.page.emulate_media(media="print", color_scheme=scheme)
    view.page.set_viewport_size(A4)
    assert view.page.evaluate(GROUND) == "rgb(255, 255, 255)"
    style = "([selector, key]) => getComputedStyle(document.querySelector(selector))[key]"
    for part in ("#classes i", "#classes .line"):
        assert view.page.evaluate(style, [part, "printColorAdjust"]) == "exact"
    assert view.page.evaluate(style, ["#map", "filter"]) == "none"
    for part in ("#map", "#history", "#of-device"):
        section = view.page.locator(f"section:has({part}), section{part}")
        assert section.evaluate("part => getComputedStyle(part).breakInside") == "avoid"
        box = section.bounding_box()
        assert box["height"] < A4["height"]
        assert section.evaluate("part => part.scrollWidth") <= A4["width"]
    assert view.page.is_visible("section:has(#map) #classes")
    assert not view.page.is_visible("#play") and not view.page.is_visible("nav")


PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


def test_a_phone_shows_all_in_its_width_and_a_finger_chooses_and_scrolls(browser, show, page_text):
    phone = show(page_text, browser.browser.new_context(**PHONE))
    assert phone.page.evaluate("document.documentElement.scrollWidth") == 390
    phone.wait("run")
    phone.page.touchscreen.tap(*phone.point_at(2, 3))
    phone.wait_for(2, 3)
    x, y = phone.point_at(1, 1)
    before = phone.page.evaluate("map.layout.yaxis.range")
    finger = phone.page.context.new_cdp_session(phone.page)
    moves = [("touchMove", [{"x": x, "y": y - far}]) for far in range(10, 210, 10)]
    for kind, points in (("touchStart", [{"x": x, "y": y}]), *moves, ("touchEnd", [])):
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    phone.wait("window.scrollY > 100")
    assert phone.page.evaluate("map.layout.yaxis.range") == before and phone.complaints == []


def test_text_from_a_config_is_text(show, cube):
    """Also where it would be a script."""
    hostile = "</script><img src=x onerror=window.harmed=1>"
    document = json.loads(cube.attrs["config"])
    document["model"]["name"] = hostile
    document["devices"] = {hostile: document.pop("device")}
    named = cube.expand_dims(device=[hostile]).assign_attrs(config=json.dumps(document))
    required = [(hostile, 3000.0, 1200.0, [("versed sine", "+z")])]
    view = show(named, title=hostile, required=required)
    view.wait("run")
    for selector in ("h1", "#device", "#classes", "footer"):
        assert hostile in view.text(selector)
    assert view.page.title() == hostile and view.complaints == []
    assert view.page.evaluate("[document.images.length, window.harmed ?? 0]") == [0, 0]


@pytest.fixture(scope="module")
def of_devices(show, handout):
    """Two axes of the device, one of which has points without a second stable shape."""
    axes = {"C": [25.0], "thickness": [1.8, 2.0, 4.4], "spring": [4.0, 7.0]}
    cube = swept(handout, **axes, skip=True)
    return cube, show(cube)


def test_each_further_axis_of_several_values_has_a_slider(of_devices):
    """And each device its own second shape."""
    cube, view = of_devices
    view.choose("where it ends")
    maps, levels = set(), []
    for t, s in np.ndindex(3, 2):
        view.slide(t, "thickness")
        view.slide(s, "spring")
        cells = cube.isel(thickness=t, spring=s, C=0)
        assert view.shows(cells, states=end_states)
        maps.add(end_states(cells).values.tobytes())
        values = ["thickness", f"{cells.thickness:g} µm"], ["spring", f"{cells.spring:g} N/m"]
        assert view.sliders() == [*values]
        if t < 2:
            view.wait("run")
            levels.append(view.page.evaluate("motion.layout.shapes[0].y0"))
    assert len(maps) == 5, "the maps of some devices are alike"
    ratio = 4 / np.sqrt(3) * cube.thickness.values[:2] / 10
    second = -5 * (1 + np.sqrt(1 - ratio**2))
    assert levels == pytest.approx(second.repeat(2).tolist(), rel=1e-6)
    view.choose("snaps")
    assert view.complaints == []


def test_a_cell_without_a_device_says_so_and_shows_no_curves(of_devices):
    _, view = of_devices
    view.slide(2, "thickness")
    view.click(1, 2)
    words = STATES[ABSENT].words
    assert view.text("#verdict").startswith(f"{words}: ")
    assert view.text("#classes") == f"{words} (12)"
    assert not view.page.is_visible("#history")
    assert view.shown("map", "colorscale")[-1][1] == GREY and words in view.hover(0, 0)
    view.slide(0, "thickness")
    assert view.page.is_visible("#history") and view.complaints == []


def test_where_f0_has_one_value_the_longest_other_takes_its_place(show, handout):
    axes = {"thickness": [1.8, 1.9, 2.0, 2.2], "spring": [4.0, 7.0], "f0": [1500.0], "C": [25.0]}
    view = show(cube := swept(handout, **axes))
    for s, words in enumerate(("4 N/m", "7 N/m")):
        view.slide(s, "spring")
        assert view.sliders() == [["spring", words]]
        assert view.shows(cube.isel(spring=s, f0=0, C=0), "thickness")
    view.click(2, 1)
    assert view.place() == [2, 1, 0, 0, 1]
    view.wait("run")
    assert view.page.evaluate("motion.layout.shapes[2].x0") == pytest.approx(1e3 / 1500)
    assert any(view.shown("map", "y", FIRST))


def test_a_sweep_to_the_snap_shows_where_it_snaps(show, handout):
    """Nothing is known of what follows, and nothing said."""
    run = Run(horizon=SETTINGS.horizon, until="snap")
    view = show(cube := swept(handout, C=[25.0], run=run))
    assert "well" not in cube
    assert view.shows(cube.isel(C=0), states=lambda cells: cells.t_snap.notnull().astype(int))
    for state, count in zip(SNAPS, (cube.t_snap.isnull(), cube.t_snap.notnull()), strict=False):
        assert f"{state.words} ({int(count.sum())})" in view.text("#classes")
    _, places = np.unique(cube.outcome.isel(C=0), return_index=True)  # a cell of each
    texts = [view.hover(*divmod(place, cube.N.size)) for place in places.tolist()]
    texts += [view.text("#verdict"), view.text("#classes")]
    assert not re.search("tripped|swing", " ".join(texts))


def drawn_shapes(view):
    """Which of both shapes of the beam a page draws with a whole line."""
    drawn = "key => getComputedStyle(document.querySelector(`.of-${key}`)).strokeDasharray"
    return [key for key in ("first", "second") if view.page.evaluate(drawn, key) == "none"]


def test_the_beam_is_drawn_as_it_starts_and_a_record_too_long_to_follow_leaves_the_map_whole(
    show, view, cube, monkeypatch
):
    assert drawn_shapes(view) == ["first"]
    monkeypatch.setattr("snapmap.applications.page.figure.MOST_PIECES", 0)
    document = json.loads(cube.attrs["config"])
    document["run"] |= {"start": "second"}
    opened = show(cube.assign_attrs(config=json.dumps(document)))
    assert drawn_shapes(opened) == ["second"]
    opened.wait("document.getElementById('followed').textContent")
    assert "too many samples" in opened.text("#followed") and not opened.page.is_visible("#history")
    assert "shape at t = " in opened.text("#verdict")
    assert opened.shows(cube.isel(C=opened.place()[0])) and opened.complaints == []
