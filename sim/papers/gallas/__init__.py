"""Gallas, Herrmann and Sokołowski (1992), beads on a vibrating belt: its claims and judges."""

from pathlib import Path

from sim.claims.claim import judge_table

judge_table(Path(__file__).with_name("claims.yaml"), f"{__name__}.judges")
