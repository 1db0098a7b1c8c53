"""The report in a browser, from a file: no error, no network, and every control does its work."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.report_pages import NASTY, bag, flight, page
from browser import WINDOW, console_errors, requested_urls, wait_until

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.vehicles.rigid_body import series

STEPS = 20
FLOWN = flight(STEPS)
SHORT = flight(8)
ARROWS = """
const found = {};
for (const trace of document.getElementById("view-plot").data)
  if ((trace.name || "").startsWith("body ") || (trace.name || "").startsWith("reference "))
    found[trace.name] = [trace.x, trace.y, trace.z].map((values) => values.slice(0, 2));
return found;
"""
CURVES = """
return document.getElementById(arguments[0])._fullData.map((trace) => Array.from(trace.y));
"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    paths = [bag(folder / "one", STEPS), SHORT.save(folder / "two.npz")]
    return page(folder / "r.html", paths[:1], [NASTY]), page(folder / "two.html", paths, ["a", "b"])


@pytest.fixture
def browser(module_browser):
    module_browser.set_window_size(*WINDOW)
    return module_browser


@pytest.fixture
def opened(browser, report):
    return open_page(browser, report[0])


def open_page(browser, path):
    browser.get(path.as_uri())
    ready = "return document.documentElement.dataset.ready === 'true'"
    wait_until(browser, lambda: browser.execute_script(ready), "the report is drawn")
    return browser


def drawn_axes(browser):
    """Return (3, 3): the tips of the arrows of body x, y, z as columns."""
    traces = browser.execute_script(ARROWS)
    return np.array([[traces[f"body {a}"][i][1] for a in "xyz"] for i in range(3)])


def press(browser, *keys):
    from selenium.webdriver.common.keys import Keys

    slider = browser.find_element("id", "time")
    for key in keys:
        slider.send_keys(getattr(Keys, key))
    return slider


def choose(browser, selector, text):
    from selenium.webdriver.support.ui import Select

    Select(browser.find_element("css selector", selector)).select_by_visible_text(text)


def test_it_opens_from_a_file_without_error_or_network(opened, report):
    assert requested_urls(opened) == [report[0].as_uri()]
    assert console_errors(opened) == []
    assert NASTY in opened.title
    assert opened.find_element("tag name", "h1").text == NASTY
    assert opened.find_elements("css selector", "h1 b, td b, pre b") == []


def test_every_diagram_is_drawn(opened):
    plots = opened.find_elements("css selector", ".plot")
    assert len(plots) > 12
    for plot in plots:
        assert plot.find_elements("css selector", "svg.main-svg, canvas"), plot.get_attribute("id")
        assert plot.size["height"] >= 100


def test_the_slider_moves_the_body_axes_to_the_recorded_attitude(opened):
    np.testing.assert_array_equal(drawn_axes(opened), FLOWN.attitude[0])
    slider = press(opened, "ARROW_RIGHT", "ARROW_RIGHT", "ARROW_RIGHT")
    assert slider.get_attribute("aria-label")
    np.testing.assert_array_equal(drawn_axes(opened), FLOWN.attitude[3])
    assert opened.find_element("id", "time-text").text == "t = 1.20 s, step 3"
    assert slider.get_attribute("aria-valuetext").startswith("t = 1.20 s, step 3, error ")
    press(opened, "END")
    np.testing.assert_array_equal(drawn_axes(opened), FLOWN.final_attitude)
    readout = opened.find_element("id", "readout").text
    quaternion = lie.to_quaternion_xyzw(FLOWN.final_attitude)
    assert ", ".join(f"{value:.5f}" for value in quaternion) in readout
    assert console_errors(opened) == []


def test_an_arrow_starts_at_the_center_and_ends_on_the_sphere(opened):
    traces = opened.execute_script(ARROWS)
    for axis in "xyz":
        foot, tip = np.array(traces[f"body {axis}"]).T
        np.testing.assert_array_equal(foot, np.zeros(3))
        assert np.linalg.norm(tip) == pytest.approx(1.0)


def test_the_button_plays_the_flight_to_its_end(opened):
    opened.find_element("id", "play").click()
    slider = opened.find_element("id", "time")
    wait_until(opened, lambda: slider.get_attribute("value") == str(STEPS), "the flight has ended")
    np.testing.assert_array_equal(drawn_axes(opened), FLOWN.final_attitude)
    assert opened.find_element("id", "play").get_attribute("aria-label") == "Play the flight"


@pytest.mark.parametrize("form", forms.REPRESENTATIONS, ids=lambda form: form.name)
def test_the_selector_changes_the_representation(opened, form):
    choose(opened, "[data-variants=attitude]", form.title.removeprefix("Attitude as "))
    drawn = np.array(opened.execute_script(CURVES, "attitude")).T
    np.testing.assert_array_equal(drawn, forms.values(form, series.attitudes(FLOWN)))
    names = opened.execute_script(
        "return document.getElementById('attitude')._fullData.map((trace) => trace.name)"
    )
    assert tuple(names) == form.components
    assert form.convention in opened.find_element("id", "n-attitude").text
    assert console_errors(opened) == []


def test_a_form_chosen_again_is_as_it_was(opened):
    before = opened.execute_script(CURVES, "attitude")
    for form in (*forms.REPRESENTATIONS, forms.QUATERNION):
        choose(opened, "[data-variants=attitude]", form.title.removeprefix("Attitude as "))
    assert opened.execute_script(CURVES, "attitude") == before


def test_the_scale_of_the_error_can_be_switched(opened):
    kind = "return document.getElementById('error')._fullLayout.yaxis.type"
    assert opened.execute_script(kind) == "log"
    box = opened.find_element("css selector", "[data-scale=error]")
    for expected in ("linear", "log"):
        box.click()
        wait_until(opened, lambda e=expected: opened.execute_script(kind) == e, expected)


@pytest.mark.parametrize("width", [360, 1280])
@pytest.mark.parametrize("page", [0, 1], ids=["one run", "two runs"])
def test_nothing_is_wider_than_the_window(browser, report, page, width):
    browser.set_window_size(width, 900)
    open_page(browser, report[page])
    fits = "return document.documentElement.scrollWidth <= window.innerWidth"
    wait_until(browser, lambda: browser.execute_script(fits), "the page fits")


def test_the_run_on_the_sphere_can_be_chosen(browser, report):
    open_page(browser, report[1])
    press(browser, "END")
    np.testing.assert_array_equal(drawn_axes(browser), FLOWN.final_attitude)
    choose(browser, "#view-run", "b")
    slider = browser.find_element("id", "time")
    wait_until(browser, lambda: slider.get_attribute("max") == "8", "the other run is shown")
    press(browser, "END")
    np.testing.assert_array_equal(drawn_axes(browser), SHORT.final_attitude)
    assert console_errors(browser) == []


def test_it_can_be_printed(opened):
    import base64

    pdf = base64.b64decode(opened.print_page())
    assert pdf.startswith(b"%PDF")
    assert console_errors(opened) == []


BOXES = """
return [...document.querySelectorAll(".chart")].map((chart) => {
  const box = chart.getBoundingClientRect();
  return [box.left, box.right, box.top, box.bottom];
});
"""
PACKED = """
return [...document.querySelectorAll(".chart")].every((chart) => chart.style.gridRowEnd);
"""


@pytest.mark.parametrize("page", [0, 1])
@pytest.mark.parametrize("width", [1280, 700])
def test_the_columns_have_no_gaps(browser, report, page, width):
    browser.set_window_size(width, 900)
    open_page(browser, report[page])
    wait_until(browser, lambda: browser.execute_script(PACKED), "the diagrams are packed")
    boxes = browser.execute_script(BOXES)
    for left, right, top, bottom in boxes:
        below = [b[2] for b in boxes if b[2] >= bottom and b[0] < right and b[1] > left]
        assert below == [] or min(below) - bottom <= room(boxes, min(below), left, right)
        over = [b for b in boxes if b[2] < bottom and b[3] > top and b[0] < right and b[1] > left]
        assert over == [[left, right, top, bottom]], "diagrams overlap"


def room(boxes, top, left, right):
    """Return the room [px] there may be above a diagram: more only above a wide one."""
    wide = max(b[1] - b[0] for b in boxes)
    is_wide = any(b[2] == top and b[1] - b[0] == wide for b in boxes)
    return 120.0 if is_wide and right - left < wide else 25.0
