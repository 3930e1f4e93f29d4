"""A judge: is a steeper flow at least a tenth faster, as this study claims?"""

import talus
from talus.claims import Untestable, above, quotient


@talus.judge(
    "steeper_is_faster",
    system="chute",
    title="Steeper flows are faster",
    statement="A flow down 18 degrees is at least a tenth faster than one down 17.",
    criterion="V(18°)/V(17°) > {least}",
    bounds={"least": 1.1},
    needs="angle 17 and 18 degrees, several replicates",
)
def steeper(evidence, *, least):
    line = evidence.line("chute", "angle", depth=2.5)
    if not {17, 18} <= set(line):
        raise Untestable("no angles 17 and 18 degrees")
    places = line[18], line[17]
    ratio = quotient(places[0].velocity, places[1].velocity)
    return [above("V(18°)/V(17°)", ratio, least, places)]
