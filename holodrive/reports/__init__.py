"""REPORT: runs as pages, pictures, films and tables. Works without a display."""

from holodrive.reports.page import Report, report

__all__ = ["Report", "report"]
