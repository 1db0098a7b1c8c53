"""Attitude transfers shared by tests: the paper's spacecraft, named and random."""

from spacecraft_gnc.studies.phogat_transfers import (
    BODY,
    figure_4,
    paper_transfer,
    random_transfer,
)

__all__ = ["BODY", "figure_4", "paper_transfer", "random_transfer"]
