"""What papers and studies claim, judged from a dataset."""
