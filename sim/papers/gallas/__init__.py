"""Gallas, Herrmann and Sokołowski (1992), beads on a vibrating belt: its claims and judges."""

from sim.study.papers import paper

paper(__name__)
