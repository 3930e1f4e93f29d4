"""Judges of Walton's claims, a function each, and what they share."""
