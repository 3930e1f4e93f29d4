"""Observables that ship: files that declare them by the call that a plug-in makes."""

from sim.base.plugins import load_shipped

# Whoever imports one of these files first, all declare what they measure as files of Talus.
load_shipped(__name__)
