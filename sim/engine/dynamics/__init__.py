"""The particle engine: neighbor list, force passes, integrators, orientation."""
