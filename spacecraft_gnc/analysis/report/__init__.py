"""Report: one self-contained HTML page for one or several runs."""

from spacecraft_gnc.analysis.report.page import report_html
from spacecraft_gnc.analysis.report.runs import Run, read_run

__all__ = ["Run", "read_run", "report_html"]
