"""The page in a headless Chromium: it draws what it is told, and its buttons work."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from analysis.flights import case1
from browser import console_errors, requested_urls, wait_until
from live.watching import Stage

from spacecraft_gnc.analysis.live.picture import Timing
from spacecraft_gnc.analysis.live.server import PageServer
from spacecraft_gnc.vehicles.rigid_body.live import RigidBodyLive

INK = """
const canvas = document.getElementById(arguments[0]);
const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
const colors = new Set();
for (let i = 0; i < data.length; i += 4) {
  if (data[i + 3] > 0) colors.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
}
return colors.size;
"""
CANVASES = {
    "scene": 5, "panel-torque": 5, "panel-error": 5, "panel-momentum": 5, "panel-source": 3
}  # fmt: skip
"""With the number of colors that each has at least."""
ZONES = ("star", "sun_keep_out_of_the_star_tracker")
LONGEST = {
    **RigidBodyLive().readouts(
        {
            "error_deg": 179.9,
            "target_error_deg": 179.9,
            "torque": np.ones(3),
            "external_torque": np.array([0.0, 0.0, 1.23e-7]),
            "source": "neighboring extremal",
            "margins_deg": dict(zip(ZONES, (-12.34, -123.4), strict=True)),
            "solve": {
                "status": "line search failed",
                "iterations": 123,
                "residual": 1e-10,
                "curvature": 1e-3,
                "solve_time": 0.0123,
            },
            "decision": {
                "alpha": 0.1234,
                "margin": 1.2e-5,
                "constraint": ZONES[1],
                "admissible": False,
            },
        },
        governed=True,
    ),
    "timing": list(
        Timing(speed=12.3, latency=0.0123, slack=-0.01, missed=6000, held=12, rejected=9).readouts()
    ),
}
"""The longest words that the status card can show."""
CUT = """
const readouts = arguments[0];
return import("./status.js").then((status) => {
  status.showNumbers(readouts);
  const card = document.getElementById("numbers");
  const edge = card.getBoundingClientRect();
  const rows = [...card.querySelectorAll("dt, dd")];
  const cut = rows.filter((row) => {
    const box = row.getBoundingClientRect();
    const wide = row.scrollWidth > row.clientWidth + 1;
    return wide || box.right > edge.right || box.bottom > edge.bottom;
  });
  return [rows.length, cut.map((row) => row.textContent), edge.height];
});
"""


@pytest.fixture
def stage():
    stage = Stage(rate=10.0)
    stage.wall.now += 1e-3  # beyond the rounding of the sums
    return stage


@pytest.fixture
def page(stage, browser):
    """Yield the page of a flight of which one frame was drawn."""
    with PageServer(stage.feed, port=None) as server:
        browser.get(server.url)
        stage.tick()
        wait_until(browser, lambda: state(browser, "drawn") > 0, "a frame is drawn")
        yield browser


def state(browser, path):
    return browser.execute_script(f"return window.view?.state?.{path} ?? 0")


def tick_and_wait(stage, browser, count=1):
    """Make frames, each once the last one has arrived, and wait until the last is drawn."""
    for _ in range(count):
        stage.tick()
        number = stage.feed._number
        wait_until(browser, lambda n=number: state(browser, "frame.number") == n, f"frame {number}")
    drawn = browser.execute_script(
        "return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>"
        " done(window.view.state.drawn))))"
    )
    assert drawn > 0


def test_it_receives_every_frame_and_draws_without_an_error(page, stage) -> None:
    tick_and_wait(stage, page, 20)
    numbers = page.execute_script("return window.view.state.numbers")
    assert numbers == list(range(numbers[0], 22))
    assert len(state(page, "rows")) == 375
    assert state(page, "frame.time") == pytest.approx(20.0)  # twenty tenths at ten times real time
    for name, least in CANVASES.items():
        assert page.execute_script(INK, name) > least, f"{name} is empty"
    assert console_errors(page) == []
    assert {url.split("/")[2].split(":")[0] for url in requested_urls(page)} == {"127.0.0.1"}


def test_the_axes_are_drawn_where_the_attitude_has_them(page, stage) -> None:
    tick_and_wait(stage, page, 3)
    azimuth, elevation = page.execute_script("return [view.scene.azimuth, view.scene.elevation]")
    toward = (
        math.cos(elevation) * math.cos(azimuth),
        math.cos(elevation) * math.sin(azimuth),
        math.sin(elevation),
    )
    right = (-math.sin(azimuth), math.cos(azimuth), 0.0)
    up = (
        toward[1] * right[2] - toward[2] * right[1],
        toward[2] * right[0] - toward[0] * right[2],
        toward[0] * right[1] - toward[1] * right[0],
    )
    x0, y0, radius = page.execute_script("return [...view.scene.center, view.scene.radius]")
    attitude = state(page, "frame.attitude")
    for i, name in enumerate("xyz"):
        axis = attitude[i::3]
        expected = (
            x0 + radius * sum(a * b for a, b in zip(axis, right, strict=True)),
            y0 - radius * sum(a * b for a, b in zip(axis, up, strict=True)),
            sum(a * b for a, b in zip(axis, toward, strict=True)),
        )
        assert state(page, f"axes.{name}") == pytest.approx(expected, abs=1e-6)


def test_a_drag_turns_the_view_and_not_the_body(page, stage) -> None:
    from selenium.webdriver import ActionChains

    before = state(page, "axes")
    canvas = page.find_element("id", "scene")
    ActionChains(page).drag_and_drop_by_offset(canvas, 120, 40).perform()
    wait_until(page, lambda: state(page, "axes") != before, "the view has turned")
    assert page.execute_script("return view.scene.azimuth") == pytest.approx(0.6 - 120 * 0.008)


def test_pause_seek_and_rate_reach_the_recording(page, stage) -> None:
    tick_and_wait(stage, page, 2)
    page.find_element("id", "play").click()
    wait_until(page, lambda: stage.flight.transport.paused, "the recording is paused")
    page.execute_script(
        "const seek = document.getElementById('seek'); seek.value = 40;"
        "seek.dispatchEvent(new Event('input')); seek.dispatchEvent(new Event('change'));"
    )
    wait_until(page, lambda: stage.flight.transport.time() == 40.0, "the recording was moved")
    tick_and_wait(stage, page, 2)
    assert state(page, "frame.step") == 100
    assert page.find_element("id", "phase").text == "paused"
    assert "t = 40.0 s" in page.find_element("id", "clock").text
    page.execute_script(
        "const rate = document.getElementById('rate'); rate.value = '2';"
        "rate.dispatchEvent(new Event('change'));"
    )
    wait_until(page, lambda: stage.flight.transport.rate == 2.0, "the rate was set")
    assert page.find_element("id", "play").text == "Play"
    page.find_element("id", "play").click()
    wait_until(page, lambda: not stage.flight.transport.paused, "the recording plays on")
    assert console_errors(page) == []


def test_it_says_that_the_recording_is_over(page, stage) -> None:
    stage.wall.now += 1000.0
    tick_and_wait(stage, page)
    assert page.find_element("id", "phase").text == "end of recording"
    assert page.find_element("id", "note").text == "the recording is over"


def test_numbers_and_names_are_shown(page, stage) -> None:
    tick_and_wait(stage, page)
    assert page.find_element("id", "title").text == "case1"
    text = page.find_element("id", "numbers").text
    assert "margin to star" in text
    assert "converged" in text
    assert "limit of |u| 10 mN m" in page.find_element("id", "panel-torque-note").text


def test_nothing_is_wider_than_a_phone(stage, browser) -> None:
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True},
    )
    with PageServer(stage.feed, port=None) as server:
        browser.get(server.url)
        stage.tick()
        wait_until(browser, lambda: state(browser, "drawn") > 0, "a frame is drawn")
        widths = browser.execute_script(
            "return [document.documentElement.scrollWidth, window.innerWidth]"
        )
    assert widths == [360, 360]


def resize(page, width: int, height: int) -> None:
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def test_the_status_card_is_never_cut(page, stage) -> None:
    for width in (320, 400, 440, 600, 756, 820, 900, 1280):
        resize(page, width, 800)
        rows, cut, height = page.execute_script(CUT, LONGEST)
        assert (rows, cut) == (42, []), width
        assert height < 700.0


def on_screen(page, name: str) -> list[float]:
    """Return top and bottom [px] of an element in the window."""
    script = "const r = document.getElementById(arguments[0]).getBoundingClientRect();"
    return page.execute_script(f"{script} return [r.top, r.bottom]", name)


def test_numbers_and_player_are_on_the_first_screen(page, stage) -> None:
    tick_and_wait(stage, page)
    for width, height in ((756, 900), (400, 800), (1280, 720)):
        resize(page, width, height)
        player, solver = on_screen(page, "player"), on_screen(page, "readout-solver")
        assert solver[1] <= player[0] < player[1] <= height, width


def test_the_curves_of_a_long_flight_fill_their_charts(browser) -> None:
    flown = case1()
    n = 40 * len(flown.time)  # 6,000 s, at rest but for the first 150
    still = {
        field.name: np.concatenate([values, np.repeat(values[-1:], n - len(values), axis=0)])
        for field in fields(flown)
        if (values := getattr(flown, field.name)) is not None
        and np.ndim(values) > 0
        and len(values) == len(flown.time)
    }
    still["time"] = flown.period * np.arange(n)
    stage = Stage(rate=50.0, trajectory=replace(flown, **still))
    with PageServer(stage.feed, port=None) as server:
        browser.get(server.url)
        stage.tick()
        wait_until(browser, lambda: state(browser, "drawn") > 0, "a frame is drawn")
        assert state(browser, "span") == [0.0, 10.0]
        for _ in range(20):
            tick_and_wait(stage, browser)
            start, end = state(browser, "span")
            now = state(browser, "frame.time")
            assert start == 0.0
            assert 1.14 * now <= end <= max(1.75 * now, 10.0)
        browser.find_element("id", "whole").click()
        tick_and_wait(stage, browser)
        assert state(browser, "span") == [0.0, pytest.approx(flown.period * (n - 1))]
    assert console_errors(browser) == []


def test_a_lost_connection_is_told_and_mended(stage, browser) -> None:
    with PageServer(stage.feed, port=None) as server:
        browser.get(server.url)
        stage.tick()
        wait_until(browser, lambda: state(browser, "drawn") > 0, "a frame is drawn")
        port = server.port
    wait_until(
        browser,
        lambda: browser.find_element("id", "phase").text == "connection lost",
        "the page says that nobody answers",
    )
    again = Stage(rate=10.0)
    with PageServer(again.feed, port=port):
        again.tick()
        wait_until(browser, lambda: state(browser, "frame.number") == 1, "the page is back")
        tick_and_wait(again, browser)
        assert len(state(browser, "rows")) == 375
