"""The particles of a run for other programs, a format each module."""
