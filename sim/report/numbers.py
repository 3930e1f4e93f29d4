"""Text of the report: numbers with intervals and thresholds, and the templates of pages."""

import shlex
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape
from uncertainties import ufloat

from sim.base.errors import count_text, duration, percent
from sim.parameters.words import SUBSCRIPT

#: Relative width of an interval below which it does not set the digits of its value.
_EXACT = 1e-4

#: Smallest p-value that is written as a number.
_LEAST_P = 1e-4

#: Free margin on either side of a strip, relative to the shown range.
_MARGIN = 0.1

TEMPLATES = Path(__file__).parent / "templates"


def finite_or_none(value: float) -> float | None:
    """Return a number, or ``None`` where it is infinite or not-a-number."""
    return value if isfinite(value) else None


def measured(check: Mapping[str, Any]) -> str:
    """Write the statistic of a check, in words where it has some, with the p-value of its test.

    Where there is no test, a number has its interval.

    >>> measured({"tested": True, "value": 0.8, "p_holds": 0.0123})
    '0.8, p = 0.012'
    >>> measured({"tested": True, "value": 0.8, "p_holds": 1e-9, "text": "all"})
    'all, p < 0.0001'
    """
    value, text = check["value"], check.get("text", "")
    if not check["tested"]:
        return text or value_with_interval(value, check["half_width"])
    text, chance = text or ("–" if value is None else f"{value:.3g}"), check["p_holds"]
    if value is None or chance is None:
        return text
    return f"{text}, p " + (f"= {chance:.2g}" if chance >= _LEAST_P else f"< {_LEAST_P:g}")


def value_with_interval(value: float | None, half_width: float | None) -> str:
    """Write a value with the half width of its interval, to two digits of the latter.

    >>> value_with_interval(0.51234, 0.0123), value_with_interval(3, 0)
    ('0.512 ± 0.012', '3')
    >>> value_with_interval(3, None), value_with_interval(None, None)
    ('3 ± ?', '–')

    A value with a far smaller interval has five digits.

    >>> value_with_interval(0.123456789, 2e-9)
    '0.12346 ± 2e-09'
    """
    if value is None:
        return "–"
    if half_width is None:
        return f"{value:.4g} ± ?"
    if half_width == 0:
        return f"{value:.4g}"
    if half_width < _EXACT * abs(value):
        return f"{value:.5g} ± {half_width:.1g}"
    return f"{ufloat(value, half_width):.2uP}".replace("±", " ± ")


def threshold(low: float | None, high: float | None) -> str:
    """Write the allowed range of a value: ``> low``, ``< high`` or ``low to high``.

    >>> threshold(0.7, None), threshold(None, 0.02), threshold(15, 17)
    ('> 0.7', '< 0.02', '15 to 17')
    """
    if low is None:
        return "any" if high is None else f"< {high:.4g}"
    return f"> {low:.4g}" if high is None else f"{low:.4g} to {high:.4g}"


def bounds(check: Mapping[str, Any]) -> str:
    """Write the one-sided 95 % bounds that decide a check: those towards its thresholds.

    >>> bounds({"value": 2.0, "bound": 0.5, "low": 1.0, "high": None})
    'above 1.5'
    >>> bounds({"value": 2.0, "bound": 0.5, "low": 1.0, "high": 3.0})
    '1.5 to 2.5'
    """
    value, bound = check["value"], check["bound"]
    if value is None or bound is None or check["low"] is check["high"]:
        return ""
    low, high = f"{value - bound:.3g}", f"{value + bound:.3g}"
    if check["low"] is None or check["high"] is None:
        is_lower = (check["low"] is None) == (check.get("verdict") == "not reproduced")
        return f"above {low}" if is_lower else f"below {high}"
    return f"{low} to {high}"


def strip(check: Mapping[str, Any]) -> dict[str, float] | None:
    """Return positions of value, bounds and allowed range on a strip, in percent of its width.

    These are ``value``; ``start`` and ``end`` of the interval between the one-sided bounds;
    ``low`` and ``high`` of the allowed range. ``None`` where value or bound is unknown.
    """
    value, half_width = check["value"], check["bound"]
    if value is None or half_width is None:
        return None
    limits = [limit for limit in (check["low"], check["high"]) if limit is not None]
    ends = [*limits, value - half_width, value + half_width]
    span = max(ends) - min(ends) or 1.0

    def place(number: float) -> float:
        return round(100 * ((number - min(ends)) / span + _MARGIN) / (1 + 2 * _MARGIN), 1)

    return {
        "value": place(value),
        "start": place(value - half_width),
        "end": place(value + half_width),
        "low": 0.0 if check["low"] is None else place(check["low"]),
        "high": 100.0 if check["high"] is None else place(check["high"]),
    }


def subscripts(text: str) -> Markup:
    """Return a text as HTML in which what follows _ in a symbol is a subscript.

    >>> str(subscripts("γ_s < 5g, law_of E"))
    'γ<sub>s</sub> &lt; 5g, law_of E'
    """
    return Markup(SUBSCRIPT.sub(r"\1<sub>\2</sub>", str(escape(text))))


def template(name: str) -> jinja2.Template:
    """Return a template of a page; undefined names raise an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=name.endswith(".html.j2"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"duration": duration, "percent": percent, "quoted": shlex.quote}
    environment.filters |= {"measured": measured, "bounds": bounds, "threshold": threshold}
    environment.filters |= {"count_text": count_text, "strip": strip, "subscripts": subscripts}
    return environment.get_template(name)
