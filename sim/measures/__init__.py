"""Measures of replicates that ship: files that declare them by the call that a plug-in makes.

`sim.parameters.variables.observables` loads them all and finds them in the registry.
"""
