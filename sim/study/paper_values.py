"""What a study takes from the papers: parameters that have the paper's value at all points."""

from collections.abc import Iterable

from sim.parameters import Parameters, field_info
from sim.parameters.common import CHOICES
from sim.parameters.words import quantity
from sim.study.papers import papers


def paper_values(points: Iterable[Parameters]) -> dict[str, list[str]]:
    """Return these parameters in words, by paper and system: ``Walton (1993), chute``.

    They are numbers of the physics that a source in a paper is declared for, but for those that
    are zero and so without effect.
    """
    by_system: dict[str, list[Parameters]] = {}
    for point in points:
        by_system.setdefault(point.system, []).append(point)
    values: dict[str, list[str]] = {}
    for system, members in by_system.items():
        unused = set.intersection(*map(_without_effect, members))
        for name, row in field_info(members[0]).items():
            is_number = type(row.default) in (int, float) and row.default != 0
            if row.role != "physics" or not is_number or name in unused:
                continue
            if any(getattr(point, name) != row.default for point in members):
                continue
            for paper in papers().values():
                if row.equation.startswith(paper.author.split()[0]):
                    texts = values.setdefault(f"{paper.quote}, {system}", [])
                    texts.append(quantity(system, name, [row.default]))
    return values


def _without_effect(point: Parameters) -> set[str]:
    """Return the parameters of laws and motions that the point does not have."""
    used, others = set[str](), set[str]()
    for choice in CHOICES:
        for name, option in point.options(choice).items():
            is_chosen = name == getattr(point, choice, name)
            (used if is_chosen else others).update((*option.owns, *option.parameters))
    return others - used


def lines(points: Iterable[Parameters]) -> list[str]:
    """Return a line for each paper and system."""
    return [
        f"left as in {heading}: {', '.join(texts)}"
        for heading, texts in paper_values(points).items()
    ]
