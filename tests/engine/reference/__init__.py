"""Slow, readable reference of both physical systems, written from the papers alone.

It shares no code with the package it checks, so an agreement of the two is evidence. Everything is
plain Python and numpy; one contact, one pair and one step at a time.
"""
