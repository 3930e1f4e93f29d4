"""Contact laws and motions that ship: a file each, which ends in the call that a plug-in makes.

Nothing imports these files: `sim.parameters` loads them all and finds them in the registry.
"""

# The laws are loaded with the parameters, before any of these files is imported otherwise.
import sim.parameters  # noqa: F401
