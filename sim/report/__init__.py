"""The report of a study: one HTML file."""

from sim.report.page import build, render

__all__ = ["build", "render"]
