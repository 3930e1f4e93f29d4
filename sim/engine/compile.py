"""One place for numba's options and for where compiled code is kept.

numba decides from a function's own file whether its cached machine code is still good, so an edit
of an imported contact law would replay old code. Here the cache folder carries the hash of all
kernels' sources instead: any edit starts a new folder.
"""

import logging
import os
import sys
from functools import partial, wraps
from time import process_time

from sim.base.additions import codes
from sim.engine.cache import CODED_KINDS, cache_directory

log = logging.getLogger("talus")


#: The plug-ins for which that folder is.
PLUGGED = codes(*CODED_KINDS)

os.environ["NUMBA_CACHE_DIR"] = str(cache_directory())

import numba  # noqa: E402  (the cache folder must be named before numba is imported)
import numpy as np  # noqa: E402
from llvmlite import ir  # noqa: E402
from numba import types  # noqa: E402
from numba.core import event  # noqa: E402
from numba.core.caching import IndexDataCacheFile  # noqa: E402
from numba.extending import intrinsic, overload, register_jitable  # noqa: E402

# Whoever has imported numba before has made it read its settings before.
numba.config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]

# numba would import scipy's linear algebra, a fifth of the start of a run, to see whether matrix
# products can be compiled. No kernel has any.
if "scipy.linalg" not in sys.modules:
    sys.modules["scipy.linalg"] = None
    import numba.np.arraymath

    del sys.modules["scipy.linalg"]


class _Compiling(event.Listener):
    """Says in the log that code is compiled, and how much processor time (s) that has taken."""

    def __init__(self):
        self.spent, self._began, self._depth = 0.0, 0.0, 0

    def on_start(self, event):
        """Begin a piece of code, which may be part of another."""
        if self._depth == 0:
            self._began = process_time()
            if self.spent == 0.0:
                plugged = f" with {PLUGGED}" if PLUGGED else ""
                log.info("compiling the engine%s; what is compiled is kept", plugged)
        self._depth += 1

    def on_end(self, event):
        """End it."""
        self._depth -= 1
        if self._depth == 0:
            self.spent += process_time() - self._began


_compiling = _Compiling()
event.register("numba:compile", _compiling)


def working_time():
    """Return the processor time (s) of this process without that in which it has compiled."""
    return process_time() - _compiling.spent


def _if_possible(save):
    """Return numba's function that keeps compiled code, for which no run shall fail."""

    @wraps(save)
    def saved(*arguments):
        try:
            save(*arguments)
        except OSError as error:
            if not saved.failed:
                log.warning("compiled code is not kept: %s", error.strerror or error)
            saved.failed = True

    saved.failed = False
    return saved


IndexDataCacheFile.save = _if_possible(IndexDataCacheFile.save)

#: Reordering of sums and fused multiply-add are allowed; ``nnan`` and ``ninf`` are left out because
#: the blow-up checks need honest comparisons with not-a-number.
FASTMATH = {"nsz", "arcp", "contract", "afn", "reassoc"}

_options = {"cache": True, "fastmath": FASTMATH, "error_model": "numpy", "nogil": True}

#: What Python calls, and pieces that only move data. A kernel that is called by another one exists
#: twice, compiled by itself and as part of the caller, and which copy runs depends on what else the
#: process has loaded. The two may round differently, so no kernel called by another may round.
kernel = numba.njit(**_options)

#: All other pieces: always copied into the caller, so that the same bits come out in every process.
#: None is made callable from Python as compiled code, which would take as long to compile again;
#: called from there it runs as it is written.
inlined = register_jitable(**_options, forceinline=True, no_cfunc_wrapper=True)

#: Kernels that round as they are written, whoever calls them: what they add up they add up in that
#: order, and no product is fused with a sum.
exact = numba.njit(cache=True, error_model="numpy", nogil=True)

#: ``@implements(generic)`` gives ``generic`` a body that numba picks by the types of the arguments.
implements = partial(
    overload, jit_options={"fastmath": FASTMATH, "error_model": "numpy", "forceinline": True}
)


@intrinsic
def vectorised(typingctx):
    """Promise, as a piece's first line, that no two of its arrays of numbers overlap.

    Without the promise LLVM must assume that every store changes what the next iteration loads
    through an index, and computes the iterations one by one.
    """

    def codegen(context, builder, signature, args):
        function = builder.function
        byte = ir.IntType(8)
        for argument in function.args:
            # Pointers to bytes are numba's reference counts, which arrays may share.
            if isinstance(argument.type, ir.PointerType) and argument.type.pointee != byte:
                argument.add_attribute("noalias")
        return context.get_dummy_value()

    return types.none(), codegen


@intrinsic
def wide_vectors(typingctx):
    """Ask, as the first line of a kernel that Python calls, for the widest vectors there are.

    Some processors prefer shorter vectors than they have; here the long ones pay.
    """

    def codegen(context, builder, signature, args):
        # llvmlite's own method knows only attributes without a value.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), codegen


@intrinsic
def _compress(typingctx, gap, k, first, out, free):
    """Append those of 8 numbers ``first``... whose ``gap`` is negative to ``out``; return how many.

    LLVM has an instruction for it that its vectoriser does not find by itself.
    """

    def codegen(context, builder, signature, args):
        lanes, i32 = 8, ir.IntType(32)
        gaps, numbers = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in ((signature.args[0], args[0]), (signature.args[3], args[3]))
        )
        vector = ir.VectorType(ir.DoubleType(), lanes)
        source = builder.bitcast(builder.gep(gaps, [args[1]]), vector.as_pointer())
        loaded = builder.load(source)
        loaded.align = 8
        negative = builder.fcmp_ordered("<", loaded, ir.Constant(vector, [0.0] * lanes))
        index = ir.VectorType(i32, lanes)
        base = builder.insert_element(
            ir.Constant(index, ir.Undefined), builder.trunc(args[2], i32), ir.Constant(i32, 0)
        )
        base = builder.shuffle_vector(
            base, ir.Constant(index, ir.Undefined), ir.Constant(index, [0] * lanes)
        )
        number = builder.add(base, ir.Constant(index, list(range(lanes))))
        target = builder.gep(numbers, [args[4]])
        store = builder.module.declare_intrinsic(
            f"llvm.masked.compressstore.v{lanes}i32",
            (),
            ir.FunctionType(
                ir.VoidType(), [index, target.type, ir.VectorType(ir.IntType(1), lanes)]
            ),
        )
        builder.call(store, [number, target, negative])
        bits = builder.bitcast(negative, ir.IntType(lanes))
        return builder.zext(builder.ctpop(bits), ir.IntType(64))

    return types.uint64(gap, types.int64, types.int64, out, types.uint64), codegen


@inlined
def append_negative(gap, size, first, out, free):
    """Append to ``out``, from ``free`` on, ``first + k`` of all k < size with a negative gap.

    Returns how many. Up to 8 entries of ``out`` behind the last may be overwritten.
    """
    count = np.uint64(0)
    whole = size - size % 8
    for k in range(0, whole, 8):
        count += _compress(gap, k, first + k, out, free + count)
    for k in range(whole, size):
        out[free + count] = first + k
        count += np.uint64(1 if gap[k] < 0.0 else 0)
    return count
