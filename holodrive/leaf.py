"""Kernels that allocate nothing, and arrays that nobody counts.

Numba counts references to arrays with calls and atomic instructions, about a hundred a control tick in a roll-out:
a third of its time, and two threads that count references to one array wait for each other. A `leaf` kernel is
compiled without the counting; it may read, write and slice arrays, but make none and keep none. `borrowed` does the
same to arrays that are handed to kernels of others.
"""

from typing import Any

from numba import njit as _njit
from numba.core import cgutils as _cgutils
from numba.extending import intrinsic

njit: Any = _njit
cgutils: Any = _cgutils  # Numba's code generation has no types


def _leaf() -> Any:
    try:
        decorator = njit(cache=True, error_model="numpy", _nrt=False)
        decorator(_leaf)  # options are read when a function is decorated; nothing is compiled
    except KeyError:  # a Numba that has given the option up: slower, and right all the same
        decorator = njit(cache=True, error_model="numpy")
    return decorator


leaf: Any = _leaf()


@leaf
def set_all(array, value):  # type: ignore[no-untyped-def]
    """Write one number into a whole vector (slice assignment would need the counting)."""
    for i in range(array.shape[0]):
        array[i] = value


def _borrowed(_context: Any, array: Any) -> Any:
    """The same array, not counted: whoever calls must hold the array for as long as the result is in use."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        proxy = cgutils.create_struct_proxy(signature.args[0])(context, builder, value=arguments[0])
        proxy.meminfo = cgutils.get_null_value(proxy.meminfo.type)
        proxy.parent = cgutils.get_null_value(proxy.parent.type)
        return proxy._getvalue()

    return array(array), code


borrowed: Any = intrinsic(_borrowed)
