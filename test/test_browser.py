"""The browser that the tests of pages stand on sees what goes wrong in a page."""

from __future__ import annotations

import pytest
from browser import REQUIRE, console_errors, requested_urls, wait_until


def open_page(browser, tmp_path, text):
    page = tmp_path / "page.html"
    page.write_text(f"<!DOCTYPE html><meta charset=utf-8><link rel=icon href=data:,>{text}")
    browser.get(page.as_uri())


def test_a_quiet_page_has_no_errors(browser, tmp_path):
    open_page(browser, tmp_path, "<p id=p>fine</p>")
    assert browser.find_element("id", "p").text == "fine"
    assert console_errors(browser) == []
    assert [url.split(":")[0] for url in requested_urls(browser)] == ["file"]


def test_an_exception_and_a_logged_error_are_seen(browser, tmp_path):
    open_page(browser, tmp_path, "<script>console.error('told'); throw Error('thrown')</script>")
    errors = console_errors(browser)
    assert any("told" in line for line in errors)
    assert any("thrown" in line for line in errors)


def test_a_request_for_the_network_is_seen(browser, tmp_path):
    open_page(browser, tmp_path, "<img src='http://127.0.0.1:9/none.png'>")
    assert "http://127.0.0.1:9/none.png" in requested_urls(browser)


def test_what_a_script_does_later_is_waited_for(browser, tmp_path):
    script = "<script>requestAnimationFrame(() => document.title = 'later')</script>"
    open_page(browser, tmp_path, script)
    assert wait_until(browser, lambda: browser.title == "later", "the title is set")


@pytest.mark.parametrize(
    ("asked", "outcome"), [("1", pytest.fail.Exception), ("", pytest.skip.Exception)]
)
def test_without_a_browser_tests_are_skipped_unless_it_is_required(monkeypatch, asked, outcome):
    from browser import _programs

    monkeypatch.setenv("PATH", "")
    monkeypatch.setenv(REQUIRE, asked)
    with pytest.raises(outcome, match="Chromium is not installed"):
        _programs()
