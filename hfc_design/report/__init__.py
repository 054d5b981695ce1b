"""The report of a run: one page that needs nothing else, and the rule tables as CSV."""

from hfc_design.report.page import REPORT, TABLES, write_report

__all__ = ["REPORT", "TABLES", "write_report"]
