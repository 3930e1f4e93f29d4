"""The report of a study: one HTML file that needs nothing beside it."""

from sim.report.page import build, render

__all__ = ["build", "render"]
