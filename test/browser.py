"""Headless Chromium for the tests of pages: fixtures and helper functions.

conftest.py provides the fixtures to every test. Without Chromium a test that uses one is
skipped with the reason; with the environment variable GNC_REQUIRE_BROWSER=1, as in CI, it fails.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

REQUIRE = "GNC_REQUIRE_BROWSER"
PATIENCE = 60.0  # [s] longest wait for a condition of a page; polled, never slept through
WINDOW = (1280, 900)  # [px]
_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
_LOGS = ("browser", "performance")
_OWN_SCHEMES = ("about:", "data:", "blob:", "chrome", "devtools:")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",  # containers run as root
    "--disable-gpu",
    "--use-angle=swiftshader",  # WebGL of 3-D diagrams, in software
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--force-device-scale-factor=1",
)


@pytest.fixture(scope="session")
def session_browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Yield a Chromium for all tests of a process: its start takes longer than most of them."""
    with chromium(tmp_path_factory.mktemp("browser")) as window:
        yield window


@pytest.fixture
def browser(session_browser: Any) -> Iterator[Any]:
    """Yield a selenium driver of a headless Chromium with a recorded console, as if it were new."""
    with as_new(session_browser) as window:
        yield window


@pytest.fixture(scope="module")
def module_browser(session_browser: Any) -> Iterator[Any]:
    """Yield one whose page stays from one test of a module to the next."""
    with as_new(session_browser) as window:
        yield window


@contextmanager
def as_new(window: Any) -> Iterator[Any]:
    """Lend a browser without the size and the logs of whoever had it before, and close the page."""
    window.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    window.set_window_size(*WINDOW)
    for log in _LOGS:
        window.get_log(log)
    yield window
    window.get("about:blank")


@contextmanager
def chromium(folder: Path) -> Iterator[Any]:
    """Start a headless Chromium with its profile in ``folder``, and stop it."""
    program, driver = _programs()
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = program
    for flag in (*_FLAGS, f"--user-data-dir={folder / 'chromium'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", dict.fromkeys(_LOGS, "ALL"))
    service = webdriver.ChromeService(executable_path=driver)
    window = webdriver.Chrome(options=options, service=service)
    try:
        window.set_window_size(*WINDOW)
        window.set_page_load_timeout(PATIENCE)
        yield window
    finally:
        window.quit()


def _programs() -> tuple[str, str]:
    """Return the paths of Chromium and its driver; skip or fail where one is missing."""
    program = next(filter(None, map(shutil.which, _CHROMIUM)), None)
    driver = shutil.which("chromedriver")
    if program and driver:
        return program, driver
    missing = "chromedriver" if program else "Chromium"
    reason = f"{missing} is not installed (apt-get install chromium chromium-driver)"
    if os.environ.get(REQUIRE) == "1":
        pytest.fail(f"{reason}, and {REQUIRE}=1 asks for it")
    pytest.skip(reason)


def wait_until(browser: Any, condition: Callable[[], Any], what: str) -> Any:
    """Return the first true value of ``condition``; fail, with the console, after `PATIENCE`."""
    from selenium.common.exceptions import TimeoutException
    from selenium.webdriver.support.ui import WebDriverWait

    try:
        return WebDriverWait(browser, PATIENCE, poll_frequency=0.05).until(lambda _: condition())
    except TimeoutException:
        pytest.fail(f"after {PATIENCE:g} s still not: {what}; console: {console(browser)}")


def console(browser: Any) -> list[str]:
    """Return the lines of the console since the last call, with their levels."""
    return [f"{item['level']}: {item['message']}" for item in browser.get_log("browser")]


def console_errors(browser: Any) -> list[str]:
    """Return the errors of the console since the last call (uncaught exceptions are among them)."""
    return [line for line in console(browser) if line.startswith("SEVERE")]


def requested_urls(browser: Any) -> list[str]:
    """Return the addresses requested by pages since the last call, without the browser's own."""
    events = (json.loads(item["message"])["message"] for item in browser.get_log("performance"))
    urls = (
        event["params"]["request"]["url"]
        for event in events
        if event["method"] == "Network.requestWillBeSent"
    )
    return [url for url in urls if not url.startswith(_OWN_SCHEMES)]
