"""Judges of Gallas' claims, a function each, and what they share."""
