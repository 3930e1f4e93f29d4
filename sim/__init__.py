"""Talus: granular flow down a chute and on a vibrating belt, from a study file to a report."""

__version__ = "0.1.0"
