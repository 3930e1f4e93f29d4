"""Deliberate bugs, to see that the tests notice them."""
