"""Pictures of the answers to questions: of surrogates, sensitivities and calibrations.

Studies ask for them by their questions, so they take no keys.
"""

from sim.study.plot_kinds import Keys, Later, plot_kind

for module, names in (
    ("surrogates", ("section", "surface", "agreement")),
    ("sensitivity", ("indices", "interactions", "screening")),
    ("calibration", ("posterior", "predictions", "experiment")),
):
    drawing = Later(f"sim.figures.{module}")
    for name in names:
        draw, table, notes = (
            getattr(drawing, f"{role}{name}{part}")
            for role, part in (("draw_", ""), ("", "_table"), ("", "_notes"))
        )
        plot_kind(name, keys=Keys(), table=table, notes=notes)(draw)
