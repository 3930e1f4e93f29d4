"""The rooms of the package: which there are, and which others each may import.

Read upwards it is the way of the data: parameters make points, a study lists them, the engine runs
them, the dataset gathers the runs, figures and claims look at it, and the report shows it all.
"""

ROOMS: dict[str, tuple[str, ...]] = {
    "base": (),
    "parameters": ("base",),
    "study": ("parameters", "base"),
    "engine": ("parameters", "base"),
    "dataset": ("engine", "study", "parameters", "base"),
    "figures": ("dataset", "engine", "study", "parameters", "base"),
    "claims": ("dataset", "engine", "study", "parameters", "base"),
    "report": ("claims", "figures", "dataset", "engine", "study", "parameters", "base"),
}
