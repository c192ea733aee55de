"""The page of a run, under the name that users import."""

from .analysis.report import write_report

__all__ = ["write_report"]
