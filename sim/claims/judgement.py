"""Outcome of a claim: its checks under every protocol and reading, and one verdict."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite

from sim.claims.claim import Claim
from sim.claims.evidence import DEFAULT
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    PAPER_INCONSISTENT,
    PROTOCOL_DEPENDENT,
    READING_DEPENDENT,
    REPRODUCED,
    REPRODUCED_IN_PART,
    UNTESTABLE,
    Check,
    combined_verdict,
    verdict_of_parts,
)

#: Protocols; the first one with runs decides.
PROTOCOLS = ("converged", "published")

#: Protocol of claims that need no runs.
MODEL = "model"


@dataclass(frozen=True)
class Variant:
    """A claim under one protocol and one reading.

    ``reason`` says why it is untestable; ``checks`` is then empty. ``checks_by_number`` holds the
    checks for each value of a number that the paper does not give. ``control`` says why the reading
    is not one of the paper's; it is empty for readings of the paper. ``unsteady`` says how many
    points are not steady: judges of a study's own claims need not test that.
    """

    protocol: str
    reading: str
    checks: tuple[Check, ...] = ()
    reason: str = ""
    checks_by_number: Mapping[float, tuple[Check, ...]] = field(default_factory=dict)
    control: str = ""
    unsteady: str = ""

    def votes_on(self, part: str) -> list[Check]:
        """Return the checks that vote on a part of the claim."""
        return [check for check in self.checks if check.has_vote and check.part == part]

    def verdict(self, parts: Iterable[str]) -> str:
        """Return the verdict of all checks together, part by part."""
        if self.reason:
            return UNTESTABLE
        if not parts:
            return combined_verdict(self.checks)
        return verdict_of_parts([self.votes_on(part) for part in parts])


@dataclass(frozen=True)
class Judgement:
    """A claim with its variants, those of the headline reading first.

    ``headline`` is the headline reading of the claim's paper; `heading` says which heads a part.
    """

    claim: Claim
    variants: tuple[Variant, ...]
    headline: str = DEFAULT

    @cached_property
    def verdict(self) -> str:
        """The headline verdict, unless it depends on something or the paper is inconsistent.

        A claim of which some parts hold, whatever they are compared with, is reproduced in part.
        """
        if self.claim.contradiction and self._headline_verdict != UNTESTABLE:
            return PAPER_INCONSISTENT
        return self._consistent_verdict

    @property
    def _consistent_verdict(self) -> str:
        """The headline verdict, unless it depends on something."""
        dependences = list(filter(None, map(self._dependence, self._parts)))
        if not dependences:
            return self._headline_verdict
        return REPRODUCED_IN_PART if REPRODUCED in self.part_verdicts.values() else dependences[0]

    @property
    def _headline_verdict(self) -> str:
        return verdict_of_parts([self._votes(self.heading(part), part) for part in self._parts])

    def heading(self, part: str = "") -> str:
        """Return the reading that gives the headline verdict on a part.

        It is the headline reading of the paper, or the default one where that has no runs for it.
        """
        return self.headline if self._voting_variants(self.headline, part) else DEFAULT

    @property
    def headings(self) -> list[str]:
        """The readings that give the headline verdict, each once."""
        return list(dict.fromkeys(map(self.heading, self._parts)))

    @property
    def decided_by(self) -> str:
        """Protocols whose runs give the headline verdict."""
        parts = [self.deciding_variant(self.heading(part), part) for part in self._parts]
        return ", ".join(dict.fromkeys(variant.protocol for variant in parts if variant))

    @property
    def part_verdicts(self) -> dict[str, str]:
        """The headline verdict on each part; empty for a claim without parts."""
        return {
            part: self._dependence(part)
            or verdict_of_parts([self._votes(self.heading(part), part)])
            for part in self.claim.parts
        }

    @property
    def by_number(self) -> dict[float, str]:
        """The verdict by value of the number that the paper does not give.

        It depends on the reading or the protocol at some values, and at others not.
        """
        number = self.claim.number
        if number is None or self.verdict == UNTESTABLE:
            return {}
        return {value: self._with_number(value)._consistent_verdict for value in number.values}

    def _with_number(self, value: float) -> "Judgement":
        if self.claim.number is None or value == self.claim.number.headline:
            return self
        variants = tuple(
            replace(variant, checks=variant.checks_by_number[value], reason="")
            for variant in self.variants
            if value in variant.checks_by_number
        )
        return replace(self, variants=variants)

    def open_checks(self, reading: str) -> list[Check]:
        """Return the checks that leave a verdict open and that more replicates would decide."""
        return [
            check
            for check in self._undecided_checks(reading)
            if isfinite(check.replicate_factor) or not (check.can_decide or check.withheld)
        ]

    def short_points(self, reading: str) -> list[str]:
        """Return the points whose runs are too short for a verdict under a reading."""
        undecided = self._undecided_checks(reading)
        return list(dict.fromkeys(point for check in undecided for point in check.short))

    def _undecided_checks(self, reading: str) -> list[Check]:
        variants = (self.deciding_variant(reading, part) for part in self._parts)
        parts = zip(variants, self._parts, strict=True)
        votes = [variant.votes_on(part) for variant, part in parts if variant]
        return [
            check
            for part_checks in votes
            if combined_verdict(part_checks) == INCONCLUSIVE
            for check in part_checks
        ]

    @property
    def readings(self) -> list[str]:
        """The readings and controls under which the claim was judged."""
        return list(dict.fromkeys(variant.reading for variant in self.variants))

    def verdict_under(self, reading: str) -> str:
        """Return the verdict under one reading, each part by the protocol that decides it."""
        return verdict_of_parts([self._votes(reading, part) for part in self._parts])

    def deciding_variant(self, reading: str, part: str = "") -> Variant | None:
        """Return the variant that decides a part: of the claim's protocol, or the converged one.

        A converged variant decides even where it is inconclusive: runs of a fixed length may show
        flows that have not relaxed.
        """
        return next(iter(self._voting_variants(reading, part).values()), None)

    def _votes(self, reading: str, part: str) -> list[Check]:
        variant = self.deciding_variant(reading, part)
        return variant.votes_on(part) if variant else []

    @property
    def _parts(self) -> list[str]:
        return list(self.claim.parts) or [""]

    @property
    def protocol_dependent(self) -> bool:
        """True where two protocols contradict each other at the headline reading, on any part."""
        return any(self._is_protocol_dependent(part) for part in self._parts)

    @property
    def reading_dependent(self) -> bool:
        """True where another reading of the paper contradicts the headline one, on any part."""
        return any(self._is_reading_dependent(part) for part in self._parts)

    def _dependence(self, part: str) -> str:
        """Return the verdict on a part that is not the same everywhere; empty for any other."""
        if self._is_reading_dependent(part):
            return READING_DEPENDENT
        return PROTOCOL_DEPENDENT if self._is_protocol_dependent(part) else ""

    def _is_protocol_dependent(self, part: str) -> bool:
        """True where protocols contradict each other, unless the claim names the one of its own."""
        return not self.claim.protocol and _contradict(
            self._voting_variants(self.heading(part), part).values(), part
        )

    def _is_reading_dependent(self, part: str) -> bool:
        """True where a reading decides a part by itself, and the other way than the headline one.

        Readings are compared under every protocol that both have runs of, and runs of different
        lengths are never mixed. There is no correction for the number of readings, which would hide
        a contradiction the better the more readings are run: two readings contradict each other by
        chance in less than 5 of 100 cases.
        """
        heading = self.heading(part)
        readings = {variant.reading for variant in self.variants if not variant.control}
        headline = self._compared_variants(heading, part)
        return any(
            _contradict((headline[protocol], other[protocol]), part)
            for other in (self._compared_variants(one, part) for one in readings - {heading})
            for protocol in headline.keys() & other.keys()
        )

    def _compared_variants(self, reading: str, part: str) -> dict[str, Variant]:
        """Return the variants of a reading that are compared with those of others, by protocol.

        What converged runs of the same reading contradict is a transient: it makes a part depend on
        the protocol, and is withheld here. This rule was chosen after the first judging. A claim
        that names its protocol is compared under that alone.
        """
        voting = self._voting_variants(reading, part)
        if self.claim.protocol:
            return {name: one for name, one in voting.items() if name == self.claim.protocol}
        if not voting.keys() >= {*PROTOCOLS}:
            return voting
        converged, published = (voting[protocol] for protocol in PROTOCOLS)
        # Some names of checks tell the protocol.
        settled = {
            check.what.replace(converged.protocol, published.protocol): check.verdict
            for check in converged.votes_on(part)
        }
        checks = tuple(
            replace(check, withheld="a transient")
            if {check.verdict, settled.get(check.what)} == {REPRODUCED, NOT_REPRODUCED}
            else check
            for check in published.checks
        )
        return voting | {published.protocol: replace(published, checks=checks)}

    def _voting_variants(self, reading: str, part: str) -> dict[str, Variant]:
        """Return the variants of a reading that vote on a part by protocol, the deciding first."""
        voting = {
            variant.protocol: variant
            for variant in self.variants
            if variant.reading == reading and variant.votes_on(part)
        }
        order = (self.claim.protocol, *PROTOCOLS, MODEL)
        return {name: voting[name] for name in dict.fromkeys(order) if name in voting}


def _contradict(variants: Iterable[Variant], part: str) -> bool:
    verdicts = {combined_verdict(variant.votes_on(part)) for variant in variants}
    return verdicts >= {REPRODUCED, NOT_REPRODUCED}
