"""What is measured: profiles, regimes, and the file that a run leaves behind."""
