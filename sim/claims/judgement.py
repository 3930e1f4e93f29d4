"""What becomes of a claim: its checks under every protocol and reading, and one verdict."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite

from sim.claims.readings import DEFAULT
from sim.claims.table import Claim
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    ON_THE_READING,
    PAPER_INCONSISTENT,
    REPRODUCED,
    RISK,
    UNTESTABLE,
    Check,
    chances,
    least,
    of_parts,
    together,
)

#: Protocols in the order in which one that was run decides.
PROTOCOLS = ("converged", "published")

#: What stands for the protocol of claims that need no runs.
MODEL = "model"


@dataclass(frozen=True)
class Variant:
    """A claim under one protocol and one reading.

    ``reason`` says why it is untestable; ``checks`` is then empty. ``others`` are the checks with
    other values of a number that the paper does not give. ``control`` says why the reading is none
    of the paper's, empty where it is one; ``unsteady`` how many points are not steady, which judges
    of a study's own claims need not ask.
    """

    protocol: str
    reading: str
    checks: tuple[Check, ...] = ()
    reason: str = ""
    others: Mapping[float, tuple[Check, ...]] = field(default_factory=dict)
    control: str = ""
    unsteady: str = ""

    def on(self, part: str) -> list[Check]:
        """Return the checks that vote on a part of the claim."""
        return [check for check in self.checks if check.deciding and check.part == part]

    def verdict(self, parts: Iterable[str]) -> str:
        """Return that of all checks together, part by part."""
        if self.reason:
            return UNTESTABLE
        if not parts:
            return together(self.checks)
        return of_parts([self.on(part) for part in parts])


@dataclass(frozen=True)
class Judgement:
    """A claim with its verdicts, those of the headline reading first."""

    claim: Claim
    variants: tuple[Variant, ...]
    headline: str = DEFAULT

    @cached_property
    def verdict(self) -> str:
        """That of the headline reading, unless it depends on the reading or contradicts itself."""
        found = self.under(self.headline)
        if self.claim.contradiction and found != UNTESTABLE:
            return PAPER_INCONSISTENT
        return ON_THE_READING if self.reading_dependent else found

    @property
    def decided_by(self) -> str:
        """Protocols whose runs give the headline verdict."""
        parts = [self.deciding(self.headline, part) for part in self._parts]
        return ", ".join(dict.fromkeys(one.protocol for one in parts if one))

    @property
    def of_parts(self) -> dict[str, str]:
        """The headline verdict on each part, empty for a claim that says one thing."""
        votes = {part: self._votes(self.headline, part) for part in self.claim.parts}
        return {part: together(found) if found else UNTESTABLE for part, found in votes.items()}

    @property
    def by_number(self) -> dict[float, str]:
        """The verdict as a function of the number that the paper does not give."""
        number = self.claim.number
        if number is None or self.verdict == UNTESTABLE:
            return {}
        return {value: self._at(value).under(self.headline) for value in number.values}

    def _at(self, value: float) -> "Judgement":
        """Return the judgement with another value of the number."""
        if self.claim.number is None or value == self.claim.number.headline:
            return self
        variants = tuple(
            Variant(one.protocol, one.reading, one.others[value], control=one.control)
            for one in self.variants
            if value in one.others
        )
        return Judgement(self.claim, variants, self.headline)

    def open(self, reading: str) -> list[Check]:
        """Return the checks that keep a reading's verdict open and more replicates would decide."""
        return [
            check
            for check in self._undecided(reading)
            if isfinite(check.times) or not (check.known or check.withheld)
        ]

    def short(self, reading: str) -> list[str]:
        """Return the points watched for too short a time for the verdict under a reading."""
        undecided = self._undecided(reading)
        return list(dict.fromkeys(point for check in undecided for point in check.short))

    def _undecided(self, reading: str) -> list[Check]:
        """Return the checks on those parts of a reading's verdict that are inconclusive."""
        decide = (self.deciding(reading, part) for part in self._parts)
        parts = zip(decide, self._parts, strict=True)
        votes = [found.on(part) for found, part in parts if found]
        return [check for checks in votes if together(checks) == INCONCLUSIVE for check in checks]

    @property
    def readings(self) -> list[str]:
        """The readings and controls that it was judged under."""
        return list(dict.fromkeys(one.reading for one in self.variants))

    def under(self, reading: str) -> str:
        """Return the verdict under one reading, each part by the protocol that decides it."""
        return of_parts([self._votes(reading, part) for part in self._parts])

    def deciding(self, reading: str, part: str = "") -> Variant | None:
        """Return the variant that decides a part: the converged one where there is one.

        A converged verdict stands even where it is open: what runs of a fixed length say beside it
        may come from flows that have not relaxed.
        """
        for protocol in (*PROTOCOLS, MODEL):
            for one in self.variants:
                if (one.protocol, one.reading) == (protocol, reading) and one.on(part):
                    return one
        return None

    def _votes(self, reading: str, part: str) -> list[Check]:
        found = self.deciding(reading, part)
        return found.on(part) if found else []

    @property
    def _parts(self) -> list[str]:
        return list(self.claim.parts) or [""]

    @property
    def protocol_dependent(self) -> bool:
        """Whether two protocols decide it, or a part of it, differently at the headline reading."""
        return any(
            _contradict(together(one.on(part)) for one in self._of(self.headline) if one.on(part))
            for part in self._parts
        )

    @property
    def reading_dependent(self) -> bool:
        """Whether two readings of the paper decide it, or a part of it, differently.

        Under the protocol that gives the headline verdict, so that runs of different lengths are
        not compared; under any where the headline reading has no runs. Of many readings one that
        differs must do so clearly as one of so many (Holm).
        """
        return any(
            _differ([chances(one.on(part)) for one in self._comparable(part, protocol)])
            for part in self._parts
            for protocol in (*PROTOCOLS, MODEL)
        )

    def _comparable(self, part: str, protocol: str) -> list[Variant]:
        """Return the readings that vote on a part under a protocol, if it is the one to look at."""
        headline = self.deciding(self.headline, part)
        if headline is not None and headline.protocol != protocol:
            return []
        return [
            one
            for one in self.variants
            if one.protocol == protocol and not one.control and one.on(part)
        ]

    def _of(self, reading: str) -> list[Variant]:
        return [one for one in self.variants if one.reading == reading]


def _differ(found: Sequence[tuple[float, float]]) -> bool:
    """Return whether a statement holds under one reading and fails under another, by p-values."""
    held, failed = ([one[way] for one in found] for way in (0, 1))
    return all(least(each) <= RISK for each in (held, failed))


def _contradict(verdicts: Iterable[str]) -> bool:
    return set(verdicts) >= {REPRODUCED, NOT_REPRODUCED}
