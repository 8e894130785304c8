"""TOML files with units and compiler-style faults: what `robots` and `worlds` share."""

from holodrive.files.pretty import errors_text, fault_text

__all__ = ["errors_text", "fault_text"]
