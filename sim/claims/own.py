"""Claims of a study's own: declared by plug-ins, judged by the rules of the papers' claims."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from pydantic import Field, PrivateAttr

from sim.base.additions import NAME, add, additions, plugin_error, require_name
from sim.base.require import require_function, require_line, require_one_of
from sim.base.words import printable
from sim.claims.evidence import Evidence
from sim.claims.table import OWN, Claim
from sim.claims.verdict import Check, Untestable
from sim.parameters import SYSTEMS
from sim.study.entries import JUDGE

#: Judge of a claim: returns at least one check, from the runs of one protocol and reading.
JudgeFunction = Callable[[Evidence], Iterable[Check]]

#: Largest number of characters of each text of a claim.
MAX_TEXT = 2000


class OwnClaim(Claim):
    """A claim of a plug-in about the runs of one system."""

    id: str = Field(pattern=NAME, description="its name")
    place: str = Field("", description="none: it is of no paper")
    reason: str = Field("", description="why the criterion is what it is")
    needs: str = Field("", description="runs that decide it")
    judge: str = Field("", description="the plug-in")
    first: None = Field(None, description="it was not judged before")
    own_system: str = Field(description="system whose runs decide it", exclude=True)
    _function: JudgeFunction = PrivateAttr()

    @property
    def paper(self) -> str:
        """`OWN`, as the claim belongs to no paper."""
        return OWN

    @property
    def system(self) -> str:
        """System whose runs decide the claim."""
        return self.own_system

    def judge_function(self) -> JudgeFunction:
        """Return the plug-in's judge; its errors are raised with their line in the plug-in."""

        def checked_judge(evidence: Evidence) -> list[Check]:
            try:
                checks = list(self._function(evidence))
                if not all(isinstance(check, Check) for check in checks) or not checks:
                    raise TypeError("a judge returns checks, one at least")
                return [_printable_check(check) for check in checks]
            except Untestable as error:
                raise Untestable(printable(str(error))) from None
            except ZeroDivisionError:
                raise
            except Exception as error:
                raise plugin_error(JUDGE, self.id, error) from None

        return checked_judge


def _printable_check(check: Check) -> Check:
    """Return a check whose texts contain no control characters and no marks of direction."""
    what, unit, withheld = map(printable, (check.what, check.unit, check.withheld))
    return replace(check, what=what, unit=unit, withheld=withheld)


def judge(
    name: str,
    *,
    system: str,
    title: str,
    statement: str,
    criterion: str,
    reason: str = "",
    needs: str = "",
) -> Callable[[JudgeFunction], JudgeFunction]:
    """Declare a claim on the runs of a study; the decorated function judges it.

    The function takes the evidence of one protocol and reading (`sim.claims.evidence`). It returns
    checks (`sim.claims.checks`), all of which must hold. It raises `Untestable` where runs are
    missing.

    Parameters
    ----------
    name : str
        Name of the claim.
    system : str
        A system of `sim.parameters.SYSTEMS`, ``chute`` or ``belt`` for instance.
    title, statement, criterion : str
        A short title; the claim itself; the condition under which it holds.
    reason, needs : str
        Why the criterion follows from the statement; the runs that decide it.
    """
    require_name(JUDGE, name)
    require_one_of(f"judge {name}: system", system, SYSTEMS)
    words: dict[str, Any] = {"title": title, "statement": statement, "criterion": criterion}
    for key, text in (words | {"reason": reason, "needs": needs}).items():
        require_line(f"judge {name}: {key}", text, empty=key not in words, longest=MAX_TEXT)
    claim = OwnClaim(id=name, reason=reason, needs=needs, own_system=system, **words)

    def register(function: JudgeFunction) -> JudgeFunction:
        require_function(f"judge {name}", function, takes=1)
        claim._function = function
        add(JUDGE, name, claim)
        return function

    return register


def own_claims() -> list[OwnClaim]:
    """Return the claims of plug-ins."""
    return [addition.value for addition in additions(JUDGE).values()]
