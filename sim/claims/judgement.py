"""Outcome of a claim: its checks under every protocol and reading, and one verdict."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite

from sim.claims.claim import Claim
from sim.claims.readings import DEFAULT
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    PAPER_INCONSISTENT,
    READING_DEPENDENT,
    REPRODUCED,
    RISK,
    UNTESTABLE,
    Check,
    combined_verdict,
    holm_p,
    p_values,
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
    """A claim with its variants, those of the headline reading first."""

    claim: Claim
    variants: tuple[Variant, ...]
    headline: str = DEFAULT

    @cached_property
    def verdict(self) -> str:
        """The headline verdict, unless it depends on the reading or the paper is inconsistent."""
        headline_verdict = self.verdict_under(self.headline)
        if self.claim.contradiction and headline_verdict != UNTESTABLE:
            return PAPER_INCONSISTENT
        return READING_DEPENDENT if self.reading_dependent else headline_verdict

    @property
    def decided_by(self) -> str:
        """Protocols whose runs give the headline verdict."""
        parts = [self.deciding_variant(self.headline, part) for part in self._parts]
        return ", ".join(dict.fromkeys(variant.protocol for variant in parts if variant))

    @property
    def part_verdicts(self) -> dict[str, str]:
        """The headline verdict on each part; empty for a claim without parts."""
        votes = {part: self._votes(self.headline, part) for part in self.claim.parts}
        return {
            part: combined_verdict(checks) if checks else UNTESTABLE
            for part, checks in votes.items()
        }

    @property
    def by_number(self) -> dict[float, str]:
        """The verdict by value of the number that the paper does not give."""
        number = self.claim.number
        if number is None or self.verdict == UNTESTABLE:
            return {}
        return {
            value: self._with_number(value).verdict_under(self.headline) for value in number.values
        }

    def _with_number(self, value: float) -> "Judgement":
        """Return the judgement with another value of the number."""
        if self.claim.number is None or value == self.claim.number.headline:
            return self
        variants = tuple(
            Variant(
                variant.protocol,
                variant.reading,
                variant.checks_by_number[value],
                control=variant.control,
            )
            for variant in self.variants
            if value in variant.checks_by_number
        )
        return Judgement(self.claim, variants, self.headline)

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
        """Return the checks on the inconclusive parts of a verdict under a reading."""
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
        """Return the variant that decides a part: the converged one where there is one.

        A converged variant decides even where it is inconclusive: runs of a fixed length may show
        flows that have not relaxed.
        """
        for protocol in (*PROTOCOLS, MODEL):
            for variant in self.variants:
                if (variant.protocol, variant.reading) == (protocol, reading) and variant.votes_on(
                    part
                ):
                    return variant
        return None

    def _votes(self, reading: str, part: str) -> list[Check]:
        variant = self.deciding_variant(reading, part)
        return variant.votes_on(part) if variant else []

    @property
    def _parts(self) -> list[str]:
        return list(self.claim.parts) or [""]

    @property
    def protocol_dependent(self) -> bool:
        """True where two protocols contradict each other at the headline reading, on any part."""
        return any(
            _contradict(
                combined_verdict(variant.votes_on(part))
                for variant in self._variants_under(self.headline)
                if variant.votes_on(part)
            )
            for part in self._parts
        )

    @property
    def reading_dependent(self) -> bool:
        """True where two readings of the paper contradict each other on any part.

        Compared are readings under the protocol of the headline verdict, so that runs of different
        lengths are not mixed. Where the headline reading has no runs, any protocol is compared. A
        contradiction must be clear with Holm's correction for the number of readings.
        """
        return any(
            _differ(
                [
                    p_values(variant.votes_on(part))
                    for variant in self._comparable_variants(part, protocol)
                ]
            )
            for part in self._parts
            for protocol in (*PROTOCOLS, MODEL)
        )

    def _comparable_variants(self, part: str, protocol: str) -> list[Variant]:
        """Return the readings that vote on a part under a protocol, if it is the one compared."""
        headline = self.deciding_variant(self.headline, part)
        if headline is not None and headline.protocol != protocol:
            return []
        return [
            variant
            for variant in self.variants
            if variant.protocol == protocol and not variant.control and variant.votes_on(part)
        ]

    def _variants_under(self, reading: str) -> list[Variant]:
        return [variant for variant in self.variants if variant.reading == reading]


def _differ(p_pairs: Sequence[tuple[float, float]]) -> bool:
    """True where a statement holds under one reading and fails under another, by p-values."""
    p_holds, p_fails = ([pair[index] for pair in p_pairs] for index in (0, 1))
    return all(holm_p(p) <= RISK for p in (p_holds, p_fails))


def _contradict(verdicts: Iterable[str]) -> bool:
    return set(verdicts) >= {REPRODUCED, NOT_REPRODUCED}
