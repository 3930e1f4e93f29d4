"""An observable over several parameters: main effects, a scatter matrix, parallel coordinates."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

for name, over, most in (
    ("main_effects", "against {}", 12),
    ("pairs", "over {}", 6),
    ("parallel", "over {}", 12),
):
    drawing = Later(f"sim.figures.{name}")
    plot_kind(
        name,
        keys=Keys(
            several="parameters", observable="y", shows=numbers, log=("y",), over=over, most=most
        ),
        table=drawing.table,
        notes=drawing.notes,
    )(drawing.draw)
