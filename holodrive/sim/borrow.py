"""Arrays without a reference count, for inner loops."""

from typing import Any

from numba.core import cgutils as _cgutils
from numba.extending import intrinsic

cgutils: Any = _cgutils  # Numba's code generation has no types


def _borrowed(_context: Any, array: Any) -> Any:
    """The same array, not counted: whoever calls must hold the array for as long as the result is in use.

    Numba counts references to arrays with atomic instructions, some sixty times a control tick here. That took a
    third of a roll-out's time, and two threads that count references to the same array wait for each other.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        proxy = cgutils.create_struct_proxy(signature.args[0])(context, builder, value=arguments[0])
        proxy.meminfo = cgutils.get_null_value(proxy.meminfo.type)
        proxy.parent = cgutils.get_null_value(proxy.parent.type)
        return proxy._getvalue()

    return array(array), code


borrowed: Any = intrinsic(_borrowed)
