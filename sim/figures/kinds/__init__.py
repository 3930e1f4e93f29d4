"""Kinds of plot that ship: their files declare them by the call that a plug-in makes.

They import nothing that draws: study files are checked against their keys.
"""

from sim.base.plugins import load_shipped

# Whoever imports one of these files first, all declare their kinds as files of Talus.
load_shipped(__name__)
