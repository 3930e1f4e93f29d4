"""Engines that ship: a file or folder each, which ends in the call that a plug-in makes.

Nothing imports them: `sim.parameters` loads them all and finds them in the registry.
"""

# The engines are loaded with the parameters, before any of these files is imported otherwise.
import sim.parameters  # noqa: F401
