"""What the papers claim, judged from a study's dataset."""
