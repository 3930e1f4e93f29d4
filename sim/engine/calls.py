"""Cheap calls of compiled kernels, from Python and from other kernels.

At each call from Python numba examines the types of all arguments, a microsecond for every two
arrays; short kernels take less. A kernel that another kernel calls is compiled again as part of its
caller and may round differently there. Called at its address it is the same machine code, with the
same bits.
"""

from collections.abc import Callable, Hashable
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

#: Functions that Python calls and addresses of machine code, by kernel and kind of arguments.
_functions: dict[tuple, Callable] = {}
_addresses: dict[tuple, int] = {}


def kind_of(*arguments: Any) -> tuple:
    """Return the types of arguments, for `call_directly` and `address_of`."""
    return tuple(map(numba.typeof, arguments))


def call_directly(kernel: Any, kind: Hashable, *arguments: Any) -> Any:
    """Call a kernel that Python calls many times with arguments of the same types.

    The types of the first call are assumed for every later call of the same ``kind``, so the kind
    must determine the types.
    """
    function = _functions.get((kernel, kind))
    if function is None:
        function = _functions[kernel, kind] = kernel.compile(kind_of(*arguments))
    return function(*arguments)


def address_of(kernel: Any, kind: Hashable, *arguments: Any) -> int:
    """Return the address of the machine code of a kernel for arguments of these types.

    The address is valid as long as this process lives. As for `call_directly`, the types of the
    first call are assumed for all of the same ``kind``.
    """
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
