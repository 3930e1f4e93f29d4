"""Templates of pages."""

import shlex
from pathlib import Path

import jinja2

from sim.base.words import duration
from sim.report.numbers import percent

TEMPLATES = Path(__file__).parent / "templates"


def template(name: str) -> jinja2.Template:
    """Return a template of a page; undefined names raise an error.

    Values are escaped in HTML, but not in Markdown.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=".html" in name,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"duration": duration, "percent": percent, "quoted": shlex.quote}
    return environment.get_template(name)
