"""Matrices of 3 × 3 agree with numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from zenvoy.laws.matrices import IDENTITY, Matrix, inverse, product, total, transposed

NUMBER = st.floats(-10.0, 10.0)
ROW = st.tuples(NUMBER, NUMBER, NUMBER)
MATRIX = st.tuples(ROW, ROW, ROW)


@given(MATRIX, MATRIX)
def test_arithmetic_is_that_of_numpy(one: Matrix, other: Matrix) -> None:
    a, b = np.array(one), np.array(other)
    np.testing.assert_allclose(product(one, other), a @ b, atol=1e-12)
    np.testing.assert_array_equal(total(one, other), a + b)
    np.testing.assert_array_equal(transposed(one), a.T)


@given(MATRIX)
@example(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.2250738585e-313, 1.0, 1.0)))
def test_an_inverse_undoes_its_matrix(matrix: Matrix) -> None:
    first, second, third = np.array(matrix)
    # np.linalg.det divides, which overflows for the example.
    assume(abs(first @ np.cross(second, third)) > 1e-2)
    np.testing.assert_allclose(product(matrix, inverse(matrix)), IDENTITY, atol=1e-8)


def test_a_singular_matrix_has_no_inverse() -> None:
    with pytest.raises(ZeroDivisionError):
        inverse(((1.0, 2.0, 3.0), (2.0, 4.0, 6.0), (0.0, 0.0, 1.0)))
