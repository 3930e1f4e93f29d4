"""Style of all figures: fonts, colours, dashes, markers, the legend and its entries."""

import math
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from matplotlib.transforms import offset_copy

from sim.figures.data import is_undecided
from sim.parameters import SYSTEMS, field_info
from sim.parameters.words import PROTOCOLS, SUBSCRIPT, setting
from sim.study.figure_spec import FigureSpec, Measure, Style
from sim.study.plot_contents import name_in_words, parameter_phrase

#: Okabe and Ito's colours, told apart by colour-blind readers, darkest first.
COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
#: Their names in the figures of papers.
NAMED = dict(zip(("black", "blue", "red", "green", "pink", "sky", "orange"), COLOURS, strict=True))
DASHES = ("-", (0, (5, 2)), (0, (5, 2, 1, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2, 1, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p")

SHORT_DASH, DASH_DOT = (0, (3, 1.5)), (0, (6, 2, 1, 2))
LONG_DASH, DOTTED = DASHES[1], DASHES[3]

#: Dash patterns by their names in the figures of papers.
PATTERNS = {"solid": "-", "short_dash": SHORT_DASH, "long_dash": LONG_DASH} | {
    **{"dash_dot": DASH_DOT, "dotted": DOTTED, "none": "none"}
}

#: matplotlib settings in force while a figure is drawn and saved: its own, whatever the user's
#: files say, and these.
SETTINGS: dict[Any, Any] = {
    **{name: value for name, value in mpl.rcParamsDefault.items() if name != "backend"},
    "figure.dpi": 200,
    "savefig.dpi": 200,
    "svg.hashsalt": "talus",
    "font.size": 9,
    "axes.labelsize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "legend.handlelength": 3.2,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.2,
    "errorbar.capsize": 2,
}

#: Opacity of what is pale.
PALE = 0.3

#: Legend entries of markers that are pale, open or have a ring.
MEANINGS = "may be steady (short run)", "not steady", "one replicate"
PALE_MEANS, OPEN_MEANS, RING_MEANS = MEANINGS

#: Look of the ring around a point of one replicate where others have bars.
RING: dict[str, Any] = {
    **{"marker": "o", "markersize": 8.5, "markerfacecolor": "none", "markeredgewidth": 0.8},
    **{"linestyle": "none", "color": "#666666", "zorder": 3.2},
}

#: Style of a line of the converged protocol beside the published one, and size of its markers where
#: no line joins them.
PALE_LINE: dict[str, Any] = {"linewidth": 3.4, "alpha": 0.4, "zorder": 1.9}
PALE_MARKER_SIZE = 7.0

#: A value in a unit that looks as if it stood in brackets.
_IN_BRACKETS = re.compile(r"^(\S+) = (\S+) (⟨\w⟩)$")

#: Colour of a caveat beneath a picture.
DOUBTFUL = "#9c2a2a"

#: Style of a level with which values are compared, and of a line of theory.
LEVEL: dict[str, Any] = {"color": "#888888", "linestyle": ":", "linewidth": 0.9, "zorder": 1}
THEORY: dict[str, Any] = {"color": "#444444", "linestyle": DASHES[3], "linewidth": 1.3, "zorder": 2}


@dataclass(frozen=True)
class CurveStyle:
    """Colour, dash pattern (``"none"`` for points alone) and marker of one curve."""

    colour: str
    dashes: Any
    marker: str = "o"


def prescribed_style(look: Style | Measure) -> CurveStyle:
    """Return the style that a paper's figure prescribes: colour and dashes by name, and marker."""
    return CurveStyle(NAMED[look.colour or "black"], PATTERNS[look.dashes or "solid"], look.marker)


def cycle_style(index: int) -> CurveStyle:
    """Return the style of the curve at ``index`` where the paper prescribes none.

    Styles with the same colour have different markers, as curves may have no line.
    """
    return CurveStyle(
        COLOURS[index % len(COLOURS)], DASHES[index % len(DASHES)], MARKERS[index % len(MARKERS)]
    )


#: Characters of a legend per inch of width; the sample of an entry counts as six.
CHARACTERS_PER_INCH = 13.5

#: Most characters in a line of a legend entry; longer entries are broken between words.
ENTRY_WIDTH = 32

#: Rows of a legend for which a figure has room, and the height that each further row adds, inches.
FREE_ROWS, ROW_HEIGHT = 3, 0.17


def legend_above(
    figure: Figure, handles: Sequence[Any], labels: Sequence[str], title: str = ""
) -> None:
    """Put a legend above all axes in up to four columns; further rows make the figure higher."""
    wrapped = [textwrap.fill(label, ENTRY_WIDTH, break_long_words=False) for label in labels]
    lines = [line for label in wrapped for line in label.splitlines()]
    room = CHARACTERS_PER_INCH * figure.get_figwidth()
    columns = max(1, min(4, int(room / (max(map(len, lines), default=0) + 6))))
    extra_rows = max(0, math.ceil(len(lines) / columns) + bool(title) - FREE_ROWS)
    figure.set_figheight(figure.get_figheight() + ROW_HEIGHT * extra_rows)
    look: dict[str, Any] = {"title": title or None, "title_fontsize": 8.5, "ncols": columns}
    figure.legend(handles, wrapped, loc="outside upper center", **look)


def legend_title(system: str, names: Iterable[str]) -> str:
    """Return what the symbols of entries mean: ``restitution e, friction μ``."""
    declared = field_info(SYSTEMS[system])
    return ", ".join(phrase(system, name) for name in dict.fromkeys(names) if declared[name].symbol)


def phrase(system: str, name: str) -> str:
    """Return name and symbol of a parameter as matplotlib reads them."""
    text = escape_label(parameter_phrase(system, name))
    return with_subscript(text, field_info(SYSTEMS[system])[name].symbol)


def faces(rows: pd.DataFrame, colour: Any) -> list[tuple[pd.Series, Any]]:
    """Return masks of points and the face of their markers: steady, perhaps steady, and others."""
    is_pale = is_undecided(rows)
    steady = (rows["regime"] == "steady") & ~is_pale
    # Opaque, so that no bar shows through.
    pale = tuple(1 - PALE * (1 - part) for part in to_rgb(colour))
    return [(steady, colour), (is_pale, pale), (~(steady | is_pale), "white")]


def explain_markers(axes: Axes, rows: pd.DataFrame) -> None:
    """Add legend entries of pale and of open markers where points have them."""
    _, (is_pale, pale), (is_open, face) = faces(rows[rows["completed"] > 0], "#666666")
    labels = axes.get_legend_handles_labels()[1]
    for mask, colour, label in ((is_pale, pale, PALE_MEANS), (is_open, face, OPEN_MEANS)):
        if mask.any() and label not in labels:
            look: dict[str, Any] = {"color": "#666666", "markerfacecolor": colour, "label": label}
            axes.plot([], [], "o", **look)


def escape_label(text: str) -> str:
    """Escape a text so that matplotlib draws it letter by letter.

    Otherwise a dollar sign begins a formula, and a legend omits an entry that begins with _.
    """
    return (" " if text.startswith("_") else "") + text.replace("$", r"\$")


def with_subscript(text: str, symbol: str) -> str:
    r"""Return a text in which what follows _ in a symbol is a subscript, as matplotlib reads it.

    >>> with_subscript("amplitude A_z/⟨d⟩", "A_z"), with_subscript("law_of E_$", "E_$")
    ('amplitude $A_{z}$/⟨d⟩', 'law_of E_$')
    """
    return text.replace(symbol, SUBSCRIPT.sub(r"$\1_{\2}$", symbol), 1) if symbol else text


def move_aside(axes: Axes, artists: Iterable[Artist], x: float = 0, y: float = 0) -> None:
    """Shift artists by points of print, without any change of the limits of the axes."""
    for artist in artists:
        figure = axes.get_figure(root=True)
        artist.set_transform(offset_copy(axes.transData, figure, x=x, y=y, units="points"))


def name_protocols(axes: Axes, system: str) -> None:
    """Add legend entries that explain pale curves: one entry per protocol."""
    words = PROTOCOLS[system]
    axes.plot([], [], color="#666666", label=words["published"])
    axes.plot([], [], color="#666666", label=words["converged"], **PALE_LINE)


#: Returns style and legend entry of a curve from the values that name it and its index.
Look = Callable[[dict[str, object], int], tuple[CurveStyle, str]]


def look_of(spec: FigureSpec, keys: Sequence[str], measure: Measure | None = None) -> Look:
    """Return a function that returns style and legend entry of each curve of a paper's figure.

    ``keys`` name a curve; its entry ends with the settings of all others that tell curves apart.
    A ``measure`` has a style of its own, and its ``entry`` follows the settings; or ``dashes``
    alone instead of those of the curve.
    """
    styles = {style.at: style for style in spec.styles}

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        named = {key: names[key] for key in keys}
        value = tuple(named.values()) if len(named) != 1 else next(iter(named.values()))
        entry = styles[value].entry if value in styles else ""
        entry = entry or spec.entry.format(**named) or settings(spec.system, named.items())
        rest = settings(spec.system, (item for item in names.items() if item[0] not in named))
        measured = ""
        if measure and measure.colour:
            style, measured = prescribed_style(measure), measure.entry
        elif value in styles:
            style = prescribed_style(styles[value])
        else:
            style = cycle_style(index + len(styles))
        if measure and measure.dashes:
            style = replace(style, dashes=PATTERNS[measure.dashes])
        return style, ", ".join(filter(None, (entry, rest, measured)))

    return look


def labels_and_styles(
    curves: Sequence[dict[str, Any]], look: Look
) -> tuple[list[str], dict[str, CurveStyle]]:
    """Return the legend entry of each curve, and the style of each entry.

    ``curves`` are the values that name each curve.
    """
    labels: list[str] = []
    styles: dict[str, CurveStyle] = {}
    for names in curves:
        parameters = {name: value for name, value in names.items() if name != "protocol"}
        style, label = look(parameters, len(styles))
        if label not in styles and style in styles.values():
            # These curves differ in a parameter that the paper's styles do not distinguish.
            style = cycle_style(len(styles) + len(MARKERS) // 2)
        styles.setdefault(label, style)
        labels.append(label)
    return labels, styles


def settings(system: str, values: Iterable[tuple[str, object]]) -> str:
    """Write values of parameters for a legend: ``e = 0.85, K1 = 100 N/m``.

    >>> settings("belt", [("frequency", 20.0), ("amplitude", 1.5), ("damping_mass", "own")])
    'f = 20 Hz, $A_{z}$/⟨d⟩ = 1.5, damping mass: own'
    """
    declared = field_info(SYSTEMS[system])
    return ", ".join(
        with_subscript(escape_label(_setting(system, name, value)), declared[name].symbol)
        for name, value in values
    )


def _setting(system: str, name: str, value: object) -> str:
    """Write a value of a parameter: words of choices, and a number over its unit in brackets."""
    if isinstance(value, str) and value:
        return setting(system, name, value).replace(f"{name} ", f"{name_in_words(name)}: ", 1)
    return _IN_BRACKETS.sub(r"\1/\3 = \2", setting(system, name, value))


#: Ratio of the ends of a logarithmic axis from which only powers of ten have ticks.
_DECADES_FROM = 300

#: Most room beyond the values, relative to their range; on a logarithmic axis as a factor.
_MARGIN, _FACTOR = 0.8, 3.0


def set_log(axes: Axes, axis: str) -> None:
    """Make the axis ``"x"`` or ``"y"`` logarithmic, with plain numbers at its ticks."""
    getattr(axes, f"set_{axis}scale")("log")
    set_plain_ticks(axes.xaxis if axis == "x" else axes.yaxis)


def set_plain_ticks(axis: Axis) -> None:
    """Put plain numbers at the ticks of a logarithmic axis, powers of ten where they are long."""
    axis.set_major_locator(_Steps())
    axis.set_major_formatter(lambda value, _: _plain(value))
    axis.set_minor_formatter(NullFormatter())


def _plain(value: float) -> str:
    """Write the number at a tick.

    >>> _plain(0.5), _plain(1e-5), _plain(2e6)
    ('0.5', '$10^{-5}$', '$2×10^{6}$')
    """
    mantissa, exponent, power = f"{value:g}".partition("e")
    if not exponent:
        return mantissa
    return f"${'' if mantissa == '1' else mantissa + '×'}10^{{{int(power)}}}$"


class _Steps(LogLocator):
    """Ticks at 1, 2 and 5 times each power of ten; over many powers at the powers alone."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        self.set_params(subs=(1, 2, 5) if vmax < _DECADES_FROM * vmin else (1,))
        return super().tick_values(vmin, vmax)


def limit_axis(axes: Axes, axis: str, *values: pd.Series) -> None:
    """Limit the axis ``"x"`` or ``"y"`` to a margin around values: bars may go far beyond it."""
    places = pd.concat(values).dropna()
    if places.empty:
        return
    first, last = places.min(), places.max()
    if getattr(axes, f"get_{axis}scale")() == "log":
        least, most = first / _FACTOR, last * _FACTOR
    else:
        room = _MARGIN * (last - first or abs(last) or 1.0)
        least, most = first - room, last + room
        # Where no value is below zero, there is but room for a marker.
        least = least if first < 0 else max(least, -0.04 * last)
    low, high = getattr(axes, f"get_{axis}lim")()
    getattr(axes, f"set_{axis}lim")(max(low, least), min(high, most))
