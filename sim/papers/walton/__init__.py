"""Walton (1993), spheres down an incline: what the paper says, and how each sentence is judged."""

from sim.study.papers import paper

paper(__name__)
