"""Talus against LAMMPS on one core: the same flows, in the same state, at the same time."""
