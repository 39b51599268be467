"""The quantile of the normal distribution, from operations that round the same on every processor.

log and cos of numpy and of the C library run different code on different processors, and differ in
their last bits. Sums, products, quotients, square roots and the split into mantissa and exponent
are exact or rounded as IEEE 754 demands, so results from these alone are the same everywhere.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Polynomial = tuple[float, ...]

# Wichura 1988, "Algorithm AS 241: The percentage points of the normal distribution", PPND16:
# numerator and denominator, highest power first.
_CENTRE: Final[tuple[Polynomial, Polynomial]] = (
    (
        2.509080928730122672e3, 3.343057558358812810e4, 6.726577092700870085e4,
        4.592195393154987145e4, 1.373169376550946112e4, 1.971590950306551442e3,
        1.331416678917843774e2, 3.387132872796366608,
    ),
    (
        5.226495278852854561e3, 2.872908573572194267e4, 3.930789580009271061e4,
        2.121379430158659586e4, 5.394196021424751107e3, 6.871870074920579083e2,
        4.231333070160091125e1, 1.0,
    ),
)  # fmt: skip
_TAIL: Final[tuple[Polynomial, Polynomial]] = (
    (
        7.74545014278341407640e-4, 2.27238449892691845833e-2, 2.41780725177450611770e-1,
        1.27045825245236838258, 3.64784832476320460504, 5.76949722146069140550,
        4.63033784615654529590, 1.42343711074968357734,
    ),
    (
        1.05075007164441684324e-9, 5.47593808499534494600e-4, 1.51986665636164571966e-2,
        1.48103976427480074590e-1, 6.89767334985100004550e-1, 1.67638483018380384940,
        2.05319162663775882187, 1.0,
    ),
)  # fmt: skip
_FAR_TAIL: Final[tuple[Polynomial, Polynomial]] = (
    (
        2.01033439929228813265e-7, 2.71155556874348757815e-5, 1.24266094738807843860e-3,
        2.65321895265761230930e-2, 2.96560571828504891230e-1, 1.78482653991729133580,
        5.46378491116411436990, 6.65790464350110377720,
    ),
    (
        2.04426310338993978564e-15, 1.42151175831644588870e-7, 1.84631831751005468180e-5,
        7.86869131145613259100e-4, 1.48753612908506148525e-2, 1.36929880922735805310e-1,
        5.99832206555887937690e-1, 1.0,
    ),
)  # fmt: skip

_LN2: Final = 0.6931471805599453
# ln m = 2 artanh((m - 1) / (m + 1)), up to the odd power that changes no bit for |x| < 0.1716.
_ARTANH: Final[Polynomial] = tuple(2.0 / n for n in range(21, 0, -2))
_HALF_STEP: Final = 2.0**-54


def normal_quantile(u: Floats) -> Floats:
    """Return z with Φ(z) = u + 2⁻⁵⁴ for u = k 2⁻⁵³ in [0, 1), to about 16 digits.

    Values are symmetric in k.
    """
    q = u - 0.5
    near_zero = u + _HALF_STEP
    near_one = (1.0 - u) - _HALF_STEP
    below = q < 0.0
    # The centre of each of 2⁵³ bins is neither 0 nor 1, and has an exact mirror image.
    p = np.where(below, near_zero, near_one)
    size = 0.5 - p
    centre = size <= 0.425
    root = np.sqrt(-natural_log(p))
    z = np.where(
        centre,
        _ratio(_CENTRE, 0.180625 - size * size) * size,
        np.where(root <= 5.0, _ratio(_TAIL, root - 1.6), _ratio(_FAR_TAIL, root - 5.0)),
    )
    return np.where(below, -z, z)


def natural_log(x: Floats) -> Floats:
    """Return ln x for x > 0, to a few units in the last place (units of 2⁻⁵³ for x near 1)."""
    mantissa, exponent = np.frexp(x)
    low = mantissa < 0.7071067811865476
    m = np.where(low, 2.0 * mantissa, mantissa)
    e = exponent - low
    s = (m - 1.0) / (m + 1.0)
    return e * _LN2 + s * _horner(_ARTANH, s * s)


def _ratio(of: tuple[Polynomial, Polynomial], x: Floats) -> Floats:
    numerator, denominator = of
    return _horner(numerator, x) / _horner(denominator, x)


def _horner(coefficients: Polynomial, x: Floats) -> Floats:
    value = np.full_like(x, coefficients[0])
    for coefficient in coefficients[1:]:
        value = value * x + coefficient
    return value
