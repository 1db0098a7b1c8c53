"""What a command that lasts shows on stderr."""

from __future__ import annotations

import sys

import pytest

from spacecraft_gnc.cli import _progress
from spacecraft_gnc.cli._progress import show_progress


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_progress, "_PATIENCE", -1.0)
    monkeypatch.setattr(_progress, "_REFRESH", 0.0)


def test_a_terminal_shows_a_bar(
    impatient: None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with show_progress("flying") as progress:
        progress(1, 2)
        progress(1, 2, "gupta2015_case1")
    out, err = capsys.readouterr()
    assert out == ""
    assert "flying" in err
    assert "gupta2015_case1" in err


def test_a_log_gets_plain_lines(impatient: None, capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress("flying") as progress:
        progress(1, 300)
        progress(2, 300)  # within ten seconds: not told
        progress(300, 300)
    assert capsys.readouterr() == ("", "flying: 1 of 300\n")


def test_the_end_is_not_told(impatient: None, capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress("flying") as progress:
        progress(300, 300)
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("silent", [True, False])
def test_what_is_quick_or_silent_shows_nothing(
    silent: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    with show_progress("flying", silent=silent) as progress:
        progress(1, 2)
    assert capsys.readouterr() == ("", "")
