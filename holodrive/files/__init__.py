"""TOML files with units and compiler-style faults: what `robots` and `worlds` share."""

from holodrive.files.pretty import errors_text, fault_text
from holodrive.files.source import table_names

__all__ = ["errors_text", "fault_text", "table_names"]
