"""Report of a campaign: one self-contained HTML page of counts, whatever the number of runs."""

from spacecraft_gnc.campaign.report.data import Data, read_data
from spacecraft_gnc.campaign.report.page import report_html

__all__ = ["Data", "read_data", "report_html"]
