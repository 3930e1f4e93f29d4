"""Claims of a study's own: what plug-ins claim, and judge by the rules of the papers' claims."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from pydantic import Field, PrivateAttr

from sim.base.additions import NAME, add, additions, fault, require_name
from sim.base.declared import require_function, require_line, require_one_of
from sim.base.words import printable
from sim.claims.evidence import Evidence
from sim.claims.table import OWN, Claim
from sim.claims.verdict import Check, Untestable
from sim.parameters import SYSTEMS
from sim.study.entries import JUDGE

#: Gives the checks of a claim, one at least, from the runs of one protocol and reading.
Judging = Callable[[Evidence], Iterable[Check]]

#: Most letters of what a claim says of itself.
_LONGEST = 2000


class OwnClaim(Claim):
    """A claim of a plug-in, of the runs of one system."""

    id: str = Field(pattern=NAME, description="its name")
    place: str = Field("", description="none: it is of no paper")
    reason: str = Field("", description="why the criterion is what it is")
    needs: str = Field("", description="runs that decide it")
    judge: str = Field("", description="the plug-in")
    first: None = Field(None, description="it was not judged before")
    own_system: str = Field(description="system whose runs decide it", exclude=True)
    _judging: Judging = PrivateAttr()

    @property
    def paper(self) -> str:
        """That it is of none."""
        return OWN

    @property
    def system(self) -> str:
        """System whose runs decide it."""
        return self.own_system

    def judging(self) -> Judging:
        """Return the function that judges it; its mistakes are told with their place in it."""

        def judged(evidence: Evidence) -> list[Check]:
            try:
                checks = list(self._judging(evidence))
                if not all(isinstance(check, Check) for check in checks) or not checks:
                    raise TypeError("a judge returns checks, one at least")
                return [_shown(check) for check in checks]
            except Untestable as error:
                raise Untestable(printable(str(error))) from None
            except ZeroDivisionError:
                raise
            except Exception as error:
                raise fault(JUDGE, self.id, error) from None

        return judged


def _shown(check: Check) -> Check:
    """Return a check whose texts move no cursor and turn no letters where they are shown."""
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
) -> Callable[[Judging], Judging]:
    """Declare a claim on the runs of a study; the function below judges it.

    That gets the evidence of one protocol and reading (`sim.claims.evidence`) and returns checks
    (`sim.claims.checks`), of which all must hold; it raises `Untestable` where runs are missing.

    Parameters
    ----------
    name : str
        Name of the claim.
    system : str
        ``chute`` or ``belt``.
    title, statement, criterion : str
        A few words; what is claimed; when it holds.
    reason, needs : str
        Why the criterion is what it is; which runs decide it.
    """
    require_name(JUDGE, name)
    require_one_of(f"judge {name}: system", system, SYSTEMS)
    words: dict[str, Any] = {"title": title, "statement": statement, "criterion": criterion}
    for key, text in (words | {"reason": reason, "needs": needs}).items():
        require_line(f"judge {name}: {key}", text, empty=key not in words, longest=_LONGEST)
    claim = OwnClaim(id=name, reason=reason, needs=needs, own_system=system, **words)

    def declared(judging: Judging) -> Judging:
        require_function(f"judge {name}", judging, takes=1)
        claim._judging = judging
        add(JUDGE, name, claim)
        return judging

    return declared


def own_claims() -> list[OwnClaim]:
    """Return the claims of plug-ins."""
    return [one.value for one in additions(JUDGE).values()]
