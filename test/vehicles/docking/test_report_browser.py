"""The 3-D view of a docking in a browser: slider, zoom and Hill's frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from analysis.report_pages import page
from browser import console_errors, requested_urls, wait_until
from docked import START, TURNED, flight, scenario

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.solids import CORNERS
from spacecraft_gnc.loop.flight import save_flights

SIZE, PORT = np.array([0.6, 0.6, 0.8]), np.array([-0.3, 0.0, 0.1])
CHIEF_PORT = np.array([0.52, 0.0, 0.2])
TURN = 2.0 * math.pi / 1000.0  # [rad/s] about z
DEPUTY = """
const mesh = document.getElementById("view-plot").data.find((trace) => trace.name === "deputy");
return [mesh.x, mesh.y, mesh.z];
"""
RANGE = "return document.getElementById('view-plot')._fullLayout.scene.xaxis.range"
SLIDE = """
const slider = document.getElementById("time");
slider.value = String(arguments[0]);
slider.dispatchEvent(new Event("input"));
"""


@pytest.fixture(scope="module")
def opened(module_browser, tmp_path_factory):
    folder, flown = tmp_path_factory.mktemp("report"), scenario()
    file = save_flights(
        folder / "docking.npz", {"": flight()}, flown.to_yaml(), flown.stated_defaults()
    )
    module_browser.get(page(folder / "r.html", [file], ["docking"]).as_uri())
    ready = "return document.documentElement.dataset.ready === 'true'"
    wait_until(module_browser, lambda: module_browser.execute_script(ready), "the report is drawn")
    return module_browser


def corners(step, turn=0.0):
    """Return where the corners of the deputy are (8, 3), in the chief frame turned about z."""
    share = (1.0 - step / 60.0) ** 2
    attitude = lie.exp(share * TURNED)
    points = CHIEF_PORT + share * START + (0.5 * SIZE * CORNERS - PORT) @ attitude.T
    return points @ lie.exp(np.array([0.0, 0.0, turn])).T


def drawn(browser):
    return np.transpose(browser.execute_script(DEPUTY))


def check(browser, name):
    browser.execute_script(f"document.getElementById('{name}').click()")


def test_the_deputy_is_drawn_where_it_was(opened):
    np.testing.assert_allclose(drawn(opened), corners(0), atol=1e-12)
    opened.execute_script(SLIDE, 24)
    np.testing.assert_allclose(drawn(opened), corners(24), atol=1e-12)
    told = opened.find_element("id", "time").get_attribute("aria-valuetext")
    assert told == "t = 120.00 s, step 24, ports 7.42 m apart, 9.05 degrees"
    check(opened, "view-frame")
    np.testing.assert_allclose(drawn(opened), corners(24, 120.0 * TURN), atol=1e-12)
    check(opened, "view-frame")
    np.testing.assert_allclose(drawn(opened), corners(24), atol=1e-12)


def test_the_picture_comes_closer_as_they_approach(opened):
    spans = []
    for step, near in ((0, True), (58, True), (58, False)):
        if not near:
            check(opened, "view-near")
        opened.execute_script(SLIDE, step)
        low, high = opened.execute_script(RANGE)
        spans.append(high - low)
        inside = drawn(opened)[:, 0]
        assert low < inside.min() < inside.max() < high
    assert spans[1] < 0.2 * spans[0]
    assert spans[2] == pytest.approx(spans[0])
    check(opened, "view-near")


def test_nothing_is_fetched_and_nothing_fails(opened):
    assert console_errors(opened) == []
    assert {url.split(":")[0] for url in requested_urls(opened)} == {"file"}
