"""Reference governors: laws that shape the reference."""

from spacecraft_gnc.governors.pass_through import PassThroughGovernor

__all__ = ["PassThroughGovernor"]
