"""Functions in place of runs: one depends on chance, one returns numbers that may be missing."""

import talus

x = talus.parameter(1.0, unit="m", description="length", ge=0, le=9)


@talus.function("noisy", parameters={"x": x}, returns={"far": ("m", "how far")})
def noisy(x, rng):
    return x + rng.normal()


@talus.function("beam", parameters={"x": x}, returns={"a": ("m", "one"), "b": ("1", "other")})
def beam(x):
    return {"a": 2 * x} if x > 2 else {"a": 2 * x, "b": 1 / x}
