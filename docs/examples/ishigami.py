"""A function in place of runs: that of Ishigami and Homma (1990), whose indices are known."""

from math import pi, sin

import talus


def angle(which):
    return talus.parameter(0.0, unit="rad", description=f"{which} angle", ge=-pi, le=pi)


@talus.function(
    "ishigami",
    parameters={"first": angle("first"), "second": angle("second"), "third": angle("third")},
    returns={"sum_of_sines": ("1", "Ishigami's function")},
)
def ishigami(first, second, third):
    return sin(first) + 7 * sin(second) ** 2 + 0.1 * third**4 * sin(first)
