"""What must hold for whatever is registered, shipped or by a plug-in of ``TALUS_PLUGINS``."""

from sim.base.additions import plain_name, plugin_options
from sim.base.plugins import load_from_environment
from sim.parameters.choices import Choice

load_from_environment()


def names_of(choice: Choice) -> list[str]:
    """Return the names of the options of a choice, those of plug-ins among them."""
    return [*choice.usual, *map(plain_name, plugin_options(choice.name))]
