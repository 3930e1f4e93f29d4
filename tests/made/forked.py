"""What the server has imported of whose forks `tests.made.processes.fork` makes processes.

The imports take most of the time of a dry run, for one. Nothing else imports this module.
"""

import numba  # noqa: F401
import smart_open  # noqa: F401
import snakemake.cli

import sim.claims.claim
import sim.claims.inference
import sim.dataset.rounds
import sim.figures.plot
import sim.study.command
import sim.study.plan  # noqa: F401
from sim.study.validate import file_models

# These import the plug-ins of Snakemake, and read the catalogue of figures.
snakemake.cli.get_argument_parser()
file_models()
