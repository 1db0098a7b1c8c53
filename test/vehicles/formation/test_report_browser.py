"""The 3-D view of a formation in a browser: slider, lines between the craft, following them."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.report_pages import page
from browser import console_errors, requested_urls, wait_until
from formation_flights import lost, scenario

from spacecraft_gnc.loop.flight import save_flights

TRACE = """
const trace = document.getElementById("view-plot").data.find((one) => one.name === arguments[0]);
return [trace.x, trace.y, trace.z];
"""
RANGES = """
const { xaxis, yaxis, zaxis, aspectratio } = document.getElementById("view-plot")._fullLayout.scene;
const { x, y, z } = aspectratio;
return [[xaxis, yaxis, zaxis].map((axis) => axis.range), [x, y, z]];
"""
SLIDE = """
const slider = document.getElementById("time");
slider.value = String(arguments[0]);
slider.dispatchEvent(new Event("input"));
"""


@pytest.fixture(scope="module")
def opened(module_browser, tmp_path_factory):
    folder, flown = tmp_path_factory.mktemp("report"), scenario()
    file = save_flights(
        folder / "formation.npz", {"": lost()}, flown.to_yaml(), flown.stated_defaults()
    )
    module_browser.get(page(folder / "r.html", [file], ["formation"]).as_uri())
    ready = "return document.documentElement.dataset.ready === 'true'"
    wait_until(module_browser, lambda: module_browser.execute_script(ready), "the report is drawn")
    return module_browser


def drawn(browser, name):
    return np.array(browser.execute_script(TRACE, name), dtype=float).T


def at(browser, step):
    browser.execute_script(SLIDE, step)


def test_the_craft_are_drawn_where_they_were(opened):
    for step in (0, 30, 100):
        at(opened, step)
        position = [*lost().position, lost().final_position][step]
        for i in range(3):
            (found,) = drawn(opened, f"sc{i + 1}")
            np.testing.assert_allclose(found, 1e-3 * position[i], rtol=1e-12, atol=1e-15)
    told = opened.find_element("id", "time").get_attribute("aria-valuetext")
    assert ", step 100, formed, at least 1.92 km apart" in told


def test_lines_are_red_where_a_limit_is_broken(opened):
    at(opened, 0)
    broken, kept = drawn(opened, "broken"), drawn(opened, "limits of a pair kept")
    start = 1e-3 * lost().position[0]
    assert (len(broken), len(kept)) == (6, 3)  # two of three lines, each with a gap behind
    np.testing.assert_allclose(broken[[0, 1, 3, 4]], start[[0, 1, 0, 2]], rtol=1e-12)
    np.testing.assert_allclose(kept[:2], start[[1, 2]], rtol=1e-12)
    at(opened, 100)
    assert (len(drawn(opened, "broken")), len(drawn(opened, "limits of a pair kept"))) == (0, 9)


def test_a_lost_craft_is_crossed_out(opened):
    at(opened, 39)
    assert drawn(opened, "lost").size == 0
    at(opened, 40)
    np.testing.assert_allclose(drawn(opened, "lost"), 1e-3 * lost().position[40, 1:2], rtol=1e-12)
    rows = opened.find_element("id", "readout").text
    assert "-, " in rows  # its delta-v and its angles are none
    assert "NaN" not in rows


def test_the_picture_follows_the_craft_at_one_scale(opened):
    def spans():
        ranges, ratio = opened.execute_script(RANGES)
        wide = np.diff(ranges)[:, 0]
        np.testing.assert_allclose(wide / wide.max(), np.array(ratio) / max(ratio), rtol=1e-6)
        return wide[1]

    at(opened, 0)
    start = spans()
    at(opened, 100)
    assert spans() < 0.5 * start
    opened.execute_script("document.getElementById('view-near').click()")
    assert spans() == pytest.approx(start, rel=0.05)
    opened.execute_script("document.getElementById('view-near').click()")


def test_nothing_is_fetched_and_nothing_fails(opened):
    assert console_errors(opened) == []
    assert {url.split(":")[0] for url in requested_urls(opened)} == {"file"}
