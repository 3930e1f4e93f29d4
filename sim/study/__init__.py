"""From a study file to its points, its boundaries and what its figures need."""
