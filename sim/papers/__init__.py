"""Papers that ship, a package each, which ends in the calls that a plug-in makes.

Nothing imports them by a statement: `sim.study.papers` loads them and finds them in the registry.
They import only what a plug-in may import.
"""

from sim.base.plugins import load_shipped

load_shipped(__name__)
