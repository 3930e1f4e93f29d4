"""The catalogue of figures: one entry, data alone, is a whole figure."""

from sim.study.catalogue.animated import ANIMATED
from sim.study.catalogue.gallas_beads import FIG_7, FIGS_4_AND_5
from sim.study.catalogue.gallas_curves import DESCRIBED, FIG_1, FIG_6
from sim.study.catalogue.gallas_profiles import FIGS_2_AND_3
from sim.study.catalogue.gallas_readings import READINGS
from sim.study.catalogue.spec import FigureSpec, Shown
from sim.study.catalogue.walton import WALTON

__all__ = ["FIGURES", "FigureSpec", "Shown"]

_GALLAS = (*FIG_1, *FIGS_2_AND_3, *FIGS_4_AND_5, FIG_6, *FIG_7, *DESCRIBED, *READINGS)

FIGURES: dict[str, FigureSpec] = {spec.name: spec for spec in (*WALTON, *_GALLAS, *ANIMATED)}
