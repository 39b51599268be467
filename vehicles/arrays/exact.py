"""Arrays that refuse what does not give the same bits on floats and on arrays.

IEEE 754 defines the last bit of sums, products, quotients and square roots, but not that of powers
and transcendental functions. There Python, numpy and numpy's vector instructions differ, for some
values only: a comparison of a few values does not find it. Sums over an axis may be in any order.
"""

from __future__ import annotations

from typing import Any, Final, NoReturn

import numpy as np

_ANY_WAY: Final = {np.minimum, np.maximum, np.fmin, np.fmax, np.logical_and, np.logical_or}
_ONE_BY_ONE: Final = {
    *(np.add, np.subtract, np.multiply, np.divide, np.negative, np.positive),
    *(np.absolute, np.fabs, np.sqrt, np.square, np.reciprocal, np.sign, np.signbit, np.copysign),
    *(np.floor, np.ceil, np.trunc, np.rint, np.floor_divide, np.remainder, np.fmod),
    *(np.greater, np.greater_equal, np.less, np.less_equal, np.equal, np.not_equal),
    *(np.logical_not, np.logical_xor, np.invert, np.bitwise_and, np.bitwise_or, np.bitwise_xor),
    *(np.isnan, np.isfinite, np.isinf, np.clip),
}


class InexactError(Exception):
    """A law uses an operation whose last bit is not defined; the text names it."""


class Exact(np.ndarray[Any, Any]):
    """An array that raises InexactError at such an operation."""

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply an operation if its result is exact."""
        if ufunc not in _ANY_WAY and (ufunc not in _ONE_BY_ONE or method != "__call__"):
            called = "" if method == "__call__" else f".{method}"
            _refuse(f"numpy.{ufunc.__name__}{called}")
        plain = [_plain(one) for one in inputs]
        if "out" in options:
            options["out"] = tuple(map(_plain, options["out"]))
        return exact(getattr(ufunc, method)(*plain, **options))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        """Call a function of numpy, such as `numpy.where`."""
        return exact(super().__array_function__(function, types, args, kwargs))

    def __pow__(self, *_: Any) -> NoReturn:
        """Refuse `x**y`, of which numpy makes different operations for different y."""
        _refuse("**")

    __rpow__ = __ipow__ = __pow__


def exact(value: Any) -> Any:
    """Return an array as one that refuses; other values unchanged."""
    return value.view(Exact) if isinstance(value, np.ndarray) else value


def _plain(value: Any) -> Any:
    return value.view(np.ndarray) if isinstance(value, Exact) else value


def _refuse(what: str) -> NoReturn:
    raise InexactError(f"it uses {what}, which gives other bits on arrays than on floats")
