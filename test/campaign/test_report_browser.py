"""The report of a campaign in a browser: no error, no network, and every control does its work."""

from __future__ import annotations

import numpy as np
import pytest
from browser import WINDOW, console_errors, requested_urls, wait_until
from campaign.made_campaigns import made

from spacecraft_gnc.campaign.report import report_html

HEAT = """
const map = document.getElementById(arguments[0]).data[0];
return map.customdata.map((row) => Array.from(row));
"""
LABELS = "return [...arguments[0].options].map((option) => option.text)"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return made(tmp_path_factory.mktemp("report") / "campaign")


@pytest.fixture(scope="module")
def page(campaign):
    path = campaign.folder / "report.html"
    path.write_text(report_html(campaign), encoding="utf-8")
    return path


@pytest.fixture
def browser(module_browser):
    module_browser.set_window_size(*WINDOW)
    return module_browser


@pytest.fixture
def opened(browser, page):
    return open_page(browser, page)


def open_page(browser, path):
    browser.get(path.as_uri())
    ready = "return document.documentElement.dataset.ready === 'true'"
    wait_until(browser, lambda: browser.execute_script(ready), "the report is drawn")
    return browser


def control(browser, pair, part):
    from selenium.webdriver.support.ui import Select

    return Select(browser.find_element("css selector", f"[data-pair={pair}][data-part={part}]"))


def test_it_opens_from_a_file_without_error_or_network(opened, page):
    assert requested_urls(opened) == [page.as_uri()]
    assert console_errors(opened) == []
    assert opened.find_elements("css selector", "h3 b, td b, pre b, option b") == []


def test_every_diagram_is_drawn(opened):
    plots = opened.find_elements("css selector", ".plot")
    assert len(plots) > 12
    for plot in plots:
        assert plot.find_elements("css selector", "svg.main-svg"), plot.get_attribute("id")
        assert plot.size["height"] >= 100


@pytest.mark.parametrize("width", [400, 1200])
def test_nothing_is_wider_than_the_window_or_overlaps(browser, page, width):
    browser.set_window_size(width, 900)
    open_page(browser, page)
    fits = "return document.documentElement.scrollWidth <= window.innerWidth"
    wait_until(browser, lambda: browser.execute_script(fits), "the page fits")
    script = """
    return [...document.querySelectorAll(".chart")].map((chart) => {
      const box = chart.getBoundingClientRect();
      return [box.left, box.right, box.top, box.bottom];
    });
    """
    packed = "return [...document.querySelectorAll('.chart')].every((c) => c.style.gridRowEnd)"
    wait_until(browser, lambda: browser.execute_script(packed), "the diagrams are packed")
    boxes = browser.execute_script(script)
    for i, (left, right, top, bottom) in enumerate(boxes):
        for other in boxes[:i]:
            beside = other[1] <= left or other[0] >= right
            assert beside or other[3] <= top or other[2] >= bottom


def test_the_density_is_of_the_chosen_columns_and_runs(opened, campaign):
    table = campaign.table()
    error, passed = table["final_error_deg"].to_numpy(), table["passed"].to_numpy()
    assert control(opened, "density", "y").first_selected_option.text == "final_error_deg"
    ended = np.isfinite(error)
    for which, chosen in (("all", ended), ("passed", passed), ("not passed", ended & ~passed)):
        control(opened, "density", "which").select_by_visible_text(which)
        assert np.sum(opened.execute_script(HEAT, "density")) == np.count_nonzero(chosen)
    control(opened, "density", "y").select_by_visible_text("settle_time_0.1deg")
    control(opened, "density", "which").select_by_visible_text("all")
    settled = np.isfinite(table["settle_time_0.1deg"].to_numpy())
    assert np.sum(opened.execute_script(HEAT, "density")) == np.count_nonzero(settled)
    assert console_errors(opened) == []


def counted(browser):
    """Return passed and total runs of each cell of the map of success rates, row by row."""
    texts = browser.execute_script(HEAT, "rates")
    return np.array([[list(map(int, text.split(" of "))) for text in row] for row in texts])


def test_the_map_of_success_is_turned_with_its_axes(opened, campaign):
    across, up = (control(opened, "rates", part) for part in ("x", "y"))
    first, second = across.first_selected_option.text, up.first_selected_option.text
    assert first != second
    before = counted(opened)
    assert before[..., 1].sum() == campaign.spec.runs
    assert before[..., 0].sum() == np.count_nonzero(campaign.table(["passed"])["passed"].to_numpy())
    across.select_by_visible_text(second)  # the other one gives way
    assert up.first_selected_option.text != second
    up.select_by_visible_text(first)
    np.testing.assert_array_equal(counted(opened), before.swapaxes(0, 1))
    assert console_errors(opened) == []


def test_counts_are_shown_linear_or_logarithmic(opened):
    kind = "return document.getElementById('metric-0')._fullLayout.yaxis.type"
    assert opened.execute_script(kind) == "log"
    opened.find_element("css selector", "[data-scale=metric-0]").click()
    wait_until(opened, lambda: opened.execute_script(kind) == "linear", "linear")


def test_bars_of_a_logarithmic_axis_lie_between_their_edges(opened):
    """Beside each other: each begins where the one before it ends."""
    script = """
    const drawn = document.querySelectorAll("#metric-0 .trace.bars:first-child .point path");
    return [...drawn].map((bar) => { const box = bar.getBBox(); return [box.x, box.width]; });
    """
    assert (
        opened.execute_script("return document.getElementById('metric-0')._fullLayout.xaxis.type")
        == "log"
    )
    boxes = np.array([box for box in opened.execute_script(script) if box[1] > 0.0])
    assert len(boxes) > 5
    np.testing.assert_allclose(boxes[:, 1], np.median(boxes[:, 1]), atol=1.5)
