"""Export of a bag to CSV, Parquet, NPZ and MAT."""

from spacecraft_gnc.analysis.export.formats import SUFFIXES, write_export
from spacecraft_gnc.analysis.export.topics import Export, read_export

__all__ = ["SUFFIXES", "Export", "read_export", "write_export"]
