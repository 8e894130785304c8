"""REPORT: runs as pages, pictures, films and tables. Works without a display."""

from holodrive.reports.exporting import export
from holodrive.reports.page import Report, report
from holodrive.reports.rendering import render
from holodrive.reports.sections import (
    ChartSection,
    ComparisonSection,
    RecordingSection,
    RunSection,
    Section,
    TableSection,
    TextSection,
)
from holodrive.reports.tables import Table, metric_table, table

__all__ = [
    "ChartSection",
    "ComparisonSection",
    "RecordingSection",
    "Report",
    "RunSection",
    "Section",
    "Table",
    "TableSection",
    "TextSection",
    "export",
    "metric_table",
    "render",
    "report",
    "table",
]
