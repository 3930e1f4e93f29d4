"""Silbert et al. (2001), spheres down a rough incline: its claims and judges."""

from sim.study.papers import paper

paper(__name__)
