"""Calls of kernels that cost less than what short kernels do.

numba looks at the types of all arguments of each call from Python, a microsecond for every two
arrays. And a kernel that another one calls is compiled once more as a part of it, and may round
differently there; called at its address it is the same machine code, with the same bits.
"""

from collections.abc import Callable, Hashable
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

#: Machine code by kernel and kind of arguments, as Python calls it, and its addresses.
_compiled: dict[tuple, Callable] = {}
_addresses: dict[tuple, int] = {}


class Direct:
    """A kernel that Python calls over and over with arguments of the same types.

    Those of the first call stand for all of the same ``kind``: with it the types must be known.
    """

    def __init__(self, kernel: Any, kind: Hashable):
        self._kernel = kernel
        self._key = (kernel, kind)

    def __call__(self, *arguments: Any) -> Any:
        found = _compiled.get(self._key)
        if found is None:
            found = _compiled[self._key] = self._kernel.compile(_types(arguments))
        return found(*arguments)


def kind_of(*arguments: Any) -> Hashable:
    """Return the types of arguments, for `Direct` and `address_of`."""
    return _types(arguments)


def _types(arguments: tuple) -> tuple:
    return tuple(map(numba.typeof, arguments))


def address_of(kernel: Any, kind: Hashable, *arguments: Any) -> int:
    """Return the address of the machine code of a kernel for such arguments.

    It is good for as long as this process lives. As for `Direct`, those of the first call stand for
    all of the same ``kind``.
    """
    key = (kernel, kind)
    if key not in _addresses:
        signature = _types(arguments)
        kernel.compile(signature)
        compiled = kernel.overloads[signature]
        name = compiled.fndesc.llvm_func_name
        _addresses[key] = compiled.library.get_pointer_to_function(name)
    return _addresses[key]


@intrinsic
def call(typingctx, address, result, *arguments):
    """Call a kernel at an address; ``result`` is any value of the type that it returns.

    The types of the arguments must be those for which it has been compiled.
    """

    result, arguments = types.unliteral(result), tuple(map(types.unliteral, arguments))

    def codegen(context, builder, signature, args):
        given = cgutils.unpack_tuple(builder, args[2])
        function = context.call_conv.get_function_type(result, arguments)
        callee = builder.inttoptr(args[0], ir.PointerType(function))
        _, returned = context.call_conv.call_function(builder, callee, result, arguments, given)
        return returned

    return result(address, result, types.BaseTuple.from_types(arguments)), codegen
