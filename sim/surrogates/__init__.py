"""Answers between the runs of a study: surrogates with errors, and the rounds that they ask for."""
