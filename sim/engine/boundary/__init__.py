"""Boundaries of the particles: the plane of chute and conveyor, the belt, the obstacle."""
