"""Walton (1993), spheres down an incline: what the paper says, and how each sentence is judged."""

from pathlib import Path

from sim.claims.claim import judge_table

judge_table(Path(__file__).with_name("claims.yaml"), f"{__name__}.judges")
