"""The catalogue of figures: what each needs of a study and what it says."""

from sim.study.catalogue.animated import ANIMATED
from sim.study.catalogue.gallas import BELT
from sim.study.catalogue.spec import FigureSpec
from sim.study.catalogue.walton import CHUTE

__all__ = ["FIGURES", "FigureSpec"]

FIGURES: dict[str, FigureSpec] = {spec.name: spec for spec in (*CHUTE, *BELT, *ANIMATED)}
