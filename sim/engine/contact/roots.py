"""Roots that compilers can vectorise and that avoid the slow divider of the processor.

Each root starts from the bit pattern, which holds the logarithm of a number. A share of it,
subtracted from a constant, gives the power within 3.5 per cent; two polynomial corrections follow.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from sim.engine.compile import inlined

#: Numbers below this count as zero: their powers would leave the range of normal numbers.
SMALLEST = 1e-290


@intrinsic
def _bits(typingctx, value):
    """Reinterpret a float64 as an int64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _float(typingctx, bits):
    """Reinterpret an int64 as a float64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), codegen


@inlined
def inverse_square_root(x):
    """Return 1/√x to about 4e-16 relative for x >= ``SMALLEST``, and anything for smaller x.

    With h = 1 - x r², 1/√x = r (1 - h)^(-1/2); the binomial series of the last factor is cut where
    the next term no longer matters.
    """
    r = _float(0x5FE6EB50C7B537A9 - (_bits(x) >> 1))
    h = 1.0 - x * r * r
    r *= 1.0 + h * (1 / 2 + h * (3 / 8 + h * (5 / 16 + h * (35 / 128))))
    h = 1.0 - x * r * r
    return r * (1.0 + h * (1 / 2 + h * (3 / 8)))


@inlined
def cube_root(x):
    """Return the cube root of x >= 0 to about 7e-16 relative, and 0 below ``SMALLEST``.

    It is x r² with r = x^(-1/3), corrected by the series of (1 - h)^(-1/3) with h = 1 - x r³.
    """
    third = _bits(x) * (1 / 3)
    r = _float(0x553EF1A9FBE76C8C - types.int64(third))
    h = 1.0 - x * r * r * r
    r *= 1.0 + h * (1 / 3 + h * (2 / 9 + h * (14 / 81 + h * (35 / 243))))
    h = 1.0 - x * r * r * r
    r *= 1.0 + h * (1 / 3 + h * (2 / 9))
    return x * r * r if x > SMALLEST else 0.0
