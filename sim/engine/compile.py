"""The options of numba, its cache folder, and the types of laws and motions, in one place.

numba checks only a function's own file to decide whether its cached machine code is valid, so an
edit of an imported contact law would run old code. Here the name of the cache folder contains the
hash of all kernels' sources: any edit starts a new folder. Laws and motions are named tuples of
numbers, whose type selects compiled functions.
"""

import logging
import os
import resource
import sys
from collections.abc import Callable, Hashable
from contextlib import suppress
from functools import cache, partial, wraps
from inspect import isfunction
from numbers import Real
from time import process_time
from typing import Any, NamedTuple
from uuid import uuid4

from sim.base.additions import attribute_errors_to, codes, plain_name
from sim.base.errors import InputError, in_short
from sim.engine.identity import COMPILED_KINDS, cache_directory
from sim.parameters import Parameters
from sim.parameters.choices import Choice

log = logging.getLogger("talus")

#: The plug-ins for which the cache folder is valid.
PLUGIN_CODES = codes(*COMPILED_KINDS)

#: Address space (bytes) below which the compiler ends the process, or waits for ever.
_SPACE = 700_000_000

_limit = resource.getrlimit(resource.RLIMIT_AS)[0]
if resource.RLIM_INFINITY != _limit < _SPACE:
    _text = (
        f"{_limit / 1e6:,.0f} MB of address space (ulimit -v); the compiler needs {_SPACE / 1e6:g}"
    )
    raise MemoryError(_text)

# Settings of numba, left from work on another program, would change or slow the code that all runs
# share, or forbid to compile. The processor remains, as the cache tells it apart, and the number of
# threads, none of them ours, of a process that may use them already.
_kept = {"NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"}
_kept |= {"NUMBA_NUM_THREADS"} if "numba" in sys.modules else set()
for _name in [name for name in os.environ if name.startswith("NUMBA_") and name not in _kept]:
    del os.environ[_name]
os.environ["NUMBA_CACHE_DIR"] = str(cache_directory())

import numba  # noqa: E402  (it reads its settings when it is imported)
import numpy as np  # noqa: E402
from llvmlite import ir  # noqa: E402
from numba import types  # noqa: E402
from numba.core import cgutils, event  # noqa: E402
from numba.core.caching import IndexDataCacheFile  # noqa: E402
from numba.core.errors import TypingError  # noqa: E402
from numba.core.ir import Loc  # noqa: E402
from numba.extending import intrinsic, overload, register_jitable  # noqa: E402

# Nor counts a file of the present folder, nor what it read if it was imported earlier.
numba.config._config_fname = os.devnull
numba.config.reload_config()

# numba would import scipy's linear algebra, a fifth of the start of a run, to see whether matrix
# products can be compiled. No kernel has any.
if "scipy.linalg" not in sys.modules:
    sys.modules["scipy.linalg"] = None
    import numba.np.arraymath

    del sys.modules["scipy.linalg"]


class _CompilationTimer(event.Listener):
    """Logs that code is compiled and measures the processor time ``seconds`` of compilation."""

    def __init__(self):
        self.seconds, self._start, self._depth = 0.0, 0.0, 0

    def on_start(self, event):
        """Note the start of a compilation, which may be part of another one."""
        if self._depth == 0:
            self._start = process_time()
            if self.seconds == 0.0:
                suffix = f" with {PLUGIN_CODES}" if PLUGIN_CODES else ""
                # Some minutes on a slow machine: told to who waits in Python or with --quiet, too.
                log.warning("compiling the engine%s; what is compiled is kept", suffix)
        self._depth += 1

    def on_end(self, event):
        """Note the end of a compilation."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += process_time() - self._start


_timer = _CompilationTimer()
event.register("numba:compile", _timer)


def working_time():
    """Return the processor time (s) of this process, compilation excluded."""
    return process_time() - _timer.seconds


_save_code, _numbered_name = IndexDataCacheFile.save, IndexDataCacheFile._data_name

#: Told once.
_warn = cache(partial(log.warning, "compiled code is not kept: %s"))


def _save_if_possible(*arguments):
    """Store compiled code; a failure is a warning and ends no run."""
    try:
        _save_code(*arguments)
    except OSError as error:
        _warn(error.strerror or error)


def _unique_name(file, number):
    """Return the name of a new file of compiled code, which no other process gives to its own.

    numba would number the files of a function in turn. Two processes that store two signatures at
    once take the same number, and later ones load the code of one signature as that of the other.
    """
    return _numbered_name(file, uuid4().int)


IndexDataCacheFile.save = _save_if_possible
IndexDataCacheFile._data_name = _unique_name

#: Reordering of sums and fused multiply-add are allowed; ``nnan`` and ``ninf`` are left out because
#: the blow-up checks need honest comparisons with not-a-number.
FASTMATH = {"nsz", "arcp", "contract", "afn", "reassoc"}

# No kernel is called from C, so none needs an entry for that, which takes time to compile.
_exact_options = {"cache": True, "error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
_options = _exact_options | {"fastmath": FASTMATH}

#: For functions that Python calls, and for pieces that only move data. A kernel called by another
#: one exists twice, compiled alone and as part of its caller. Which copy runs depends on what else
#: the process has loaded. The two may round differently, so no kernel called by another may round.
kernel = numba.njit(**_options)

#: For kernels that allocate no array, and call none that does but at its address (`calls`): numba
#: would count the references to all arrays that named tuples hold, some hundred calls a step.
loop_kernel = numba.njit(**_options, _nrt=False)

#: For all other pieces: always copied into the caller, so that every process gives the same bits.
#: Python calls them as plain Python functions: a compiled entry would double the time to compile.
inlined = register_jitable(**_options, forceinline=True)


@cache
def inlined_with_calls(function):
    """Register a function of a plug-in, once, with the plain functions that it calls by name."""
    for other in map(function.__globals__.get, function.__code__.co_names):
        if isfunction(other) and other is not function:
            inlined_with_calls(other)
    return inlined(function)


#: For kernels that round as they are written, whoever calls them: sums keep their order, and no
#: product is fused with a sum.
exact = numba.njit(**_exact_options)

#: ``@implements(generic)`` gives ``generic`` a body that numba picks by the types of the arguments.
_body_options = {"error_model": "numpy", "forceinline": True, "no_cfunc_wrapper": True}
implements = partial(overload, jit_options=_body_options | {"fastmath": FASTMATH})


def by_type(choose):
    """Turn a function of types, which returns a body, into a function that kernels call.

    It is inlined, as all pieces are; Python cannot call it.
    """

    @wraps(choose)
    def generic(*arguments):
        raise NotImplementedError

    implements(generic)(choose)
    return generic


@intrinsic
def assume_no_alias(typingctx):
    """Promise, in the first line of a piece, that no two of its arrays of numbers overlap.

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
def prefer_wide_vectors(typingctx):
    """Request, in the first line of a kernel that Python calls, the widest vectors available.

    For some processors LLVM prefers vectors shorter than the longest ones; here the longest are
    faster.
    """

    def codegen(context, builder, signature, args):
        # llvmlite's own method knows only attributes without a value.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), codegen


#: Numbers in the widest vectors. A loop over a multiple of it has no remainder, whose iterations
#: the compiler would run one by one.
LANES = 8

#: For each set of lanes, as the bits of a number, the lanes in it, first in the list.
_LANES_IN = [
    [lane for lane in range(LANES) if bits >> lane & 1] + [0] * (LANES - bits.bit_count())
    for bits in range(2**LANES)
]


@intrinsic
def _compress(typingctx, gap, k, first, out, free):
    """Append to ``out`` those of the 8 numbers from ``first`` on whose ``gap`` is negative.

    Returns their number. A table says which: the instructions that compress are slow on some
    processors, and others have none.
    """

    def codegen(context, builder, signature, args):
        byte, i32 = ir.IntType(8), ir.IntType(32)
        gaps, numbers = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in ((signature.args[0], args[0]), (signature.args[3], args[3]))
        )
        vector = ir.VectorType(ir.DoubleType(), LANES)
        loaded = builder.load(builder.bitcast(builder.gep(gaps, [args[1]]), vector.as_pointer()))
        loaded.align = 8
        negative = builder.fcmp_ordered("<", loaded, ir.Constant(vector, [0.0] * LANES))
        bits = builder.bitcast(negative, ir.IntType(LANES))
        row = ir.VectorType(byte, LANES)
        rows = ir.ArrayType(row, len(_LANES_IN))
        table = cgutils.global_constant(builder, "lanes_in", ir.Constant(rows, _LANES_IN))
        zero, index = ir.Constant(i32, 0), ir.VectorType(i32, LANES)
        lanes = builder.load(builder.gep(table, [zero, builder.zext(bits, i32)]))
        nothing = ir.Constant(index, ir.Undefined)
        base = builder.insert_element(nothing, builder.trunc(args[2], i32), zero)
        base = builder.shuffle_vector(base, nothing, ir.Constant(index, [0] * LANES))
        target = builder.bitcast(builder.gep(numbers, [args[4]]), index.as_pointer())
        builder.store(builder.add(base, builder.zext(lanes, index)), target).align = 4
        return builder.zext(builder.ctpop(bits), ir.IntType(64))

    return types.uint64(gap, types.int64, types.int64, out, types.uint64), codegen


@inlined
def append_negative(gap, size, first, out, free):
    """Append ``first + k`` to ``out``, from index ``free``, for all k < size with a negative gap.

    Returns their number. Up to 8 entries of ``out`` behind the last may be overwritten.
    """
    count = np.uint64(0)
    whole = size - size % LANES
    for k in range(0, whole, LANES):
        count += _compress(gap, k, first + k, out, free + count)
    for k in range(whole, size):
        out[free + count] = first + k
        count += np.uint64(1 if gap[k] < 0.0 else 0)
    return count


#: The types registered so far.
adopted_types: set[type] = set()


def adopt_type(kind: type, has_plugin: bool = True) -> bool:
    """Register a type, of a plug-in or of Talus; return True where it is new.

    Raises `InputError` when the engine was loaded before the plug-in: code compiled with the
    plug-in would be stored in the cache folder of processes without it.
    """
    if kind in adopted_types:
        return False
    if has_plugin and codes(*COMPILED_KINDS) != PLUGIN_CODES:
        raise InputError(
            "load a plug-in with a law or a motion before the first flow of a process, and import "
            "nothing of sim.engine in it; start another process"
        )
    adopted_types.add(kind)
    return True


def make_numbers(
    choice: Choice, p: Parameters, register: Callable[[type, Any], None], *arguments: Any
) -> NamedTuple:
    """Return the numbers of the option that a point has, which ``make`` gives of the arguments.

    Where their type is new, ``register`` adds its functions, those of the option.
    """
    name, option = getattr(p, choice.name, choice.usual[0]), p.option(choice.name)
    has_plugin = choice.is_own(name)
    with attribute_errors_to(choice.name, plain_name(name)):
        numbers = option.make(*arguments)
        is_named = isinstance(numbers, tuple) and hasattr(numbers, "_fields")
        if has_plugin and not (is_named and all(isinstance(one, Real) for one in numbers)):
            raise TypeError(f"make returns a NamedTuple of numbers: got {in_short(numbers)}")
        if option.has_functions(type(numbers)) and adopt_type(type(numbers), has_plugin):
            register(type(numbers), option)
    return numbers


def typing_error(function: Callable[..., Any], message: str) -> TypingError:
    """Return the error of a compiled function of a plug-in, with its file and line."""
    code = function.__code__
    return TypingError(message, Loc(code.co_filename, code.co_firstlineno))


def require_numbers(
    function: Callable[..., Any], label: str, returned: Any, count: int, kind: type = types.Number
) -> None:
    """Raise a typing error unless a compiled function returns a tuple of ``count`` numbers.

    ``label`` names the value in the message; ``returned`` holds its types.
    """
    is_tuple = isinstance(returned, tuple | types.BaseTuple) and len(returned) == count
    if not is_tuple or not all(isinstance(types.unliteral(part), kind) for part in returned):
        noun = "floats" if kind is types.Float else "numbers"
        raise typing_error(function, f"{label} is no tuple of {count} {noun}: got {returned}")


# Cheap calls of compiled kernels, from Python and from other kernels.
#
# At each call from Python numba examines the types of all arguments, a microsecond for every two
# arrays; short kernels take less. A kernel that another kernel calls is compiled again as part of
# its caller and may round differently there. Called at its address it is the same machine code,
# with the same bits.

#: Functions that Python calls and addresses of machine code, by kernel and kind of arguments.
_functions: dict[tuple, Callable] = {}
_addresses: dict[tuple, int] = {}


def kind_of(*arguments: Any) -> tuple:
    """Return the types of arguments, for `call_directly` and `address_of`."""
    return tuple(map(numba.typeof, arguments))


def call_by_type(kernel: Any, *arguments: Any) -> Any:
    """Call a kernel whose arguments may hold numbers of a plug-in.

    numba itself tells named tuples apart by the names of their types without those of the modules:
    of two plug-ins that give their types one name, both would be served by the code of the first.
    """
    return kernel.compile(kind_of(*arguments))(*arguments)


#: True in a process that compiles ahead of another one.
_ahead = False


class Compiled(Exception):
    """Raised in place of a call, in a process that compiles ahead."""


def compile_ahead(task: Callable[[], object]) -> None:
    """Compile the kernel that ``task`` would call first and none that is called at its address.

    For a process that runs nothing any more, beside one that does the same task and begins with the
    others. What the two take on two cores: docs/performance.md.
    """
    global _ahead
    _ahead = True
    with suppress(Compiled):
        task()


def call_directly(kernel: Any, kind: Hashable, *arguments: Any) -> Any:
    """Call a kernel that Python calls many times with arguments of the same types.

    The types of the first call are assumed for every later call of the same ``kind``, so the kind
    must determine the types.
    """
    function = _functions.get((kernel, kind))
    if function is None:
        function = _functions[kernel, kind] = kernel.compile(kind_of(*arguments))
    if _ahead:
        raise Compiled
    return function(*arguments)


def address_of(kernel: Any, kind: Hashable, *arguments: Any) -> int:
    """Return the address of the machine code of a kernel for arguments of these types.

    The address is valid as long as this process lives. As for `call_directly`, the types of the
    first call are assumed for all of the same ``kind``.
    """
    if _ahead:
        return 0
    key = (kernel, kind)
    if key not in _addresses:
        signature = kind_of(*arguments)
        kernel.compile(signature)
        compiled = kernel.overloads[signature]
        name = compiled.fndesc.llvm_func_name
        _addresses[key] = compiled.library.get_pointer_to_function(name)
    return _addresses[key]


@intrinsic
def call(typingctx, address, result, *arguments):
    """Call a kernel at an address; ``result`` is any value of its return type.

    The kernel must have been compiled for the types of the arguments.
    """

    result, arguments = types.unliteral(result), tuple(map(types.unliteral, arguments))

    def codegen(context, builder, signature, args):
        values = cgutils.unpack_tuple(builder, args[2])
        function = context.call_conv.get_function_type(result, arguments)
        callee = builder.inttoptr(args[0], ir.PointerType(function))
        _, returned = context.call_conv.call_function(builder, callee, result, arguments, values)
        return returned

    return result(address, result, types.BaseTuple.from_types(arguments)), codegen
