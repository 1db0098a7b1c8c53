"""The reference page says what the schema says."""

from __future__ import annotations

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_page_is_current():
    tool = runpy.run_path(str(ROOT / "tools" / "scenario_reference.py"))
    written = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    assert written == tool["page"](), "run: python tools/scenario_reference.py"
