"""Export of the particles of a run for other programs, one module per format."""
