"""Small dense matrices in plain arithmetic: the same bits on every machine.

LAPACK and BLAS choose by the processor in which order they sum, and in a chaotic cell the last bit
of a mode shape decides. Whatever feeds a run is therefore computed here, or by single operations.
"""

import numpy as np
from numba import njit

PLAIN = {"error_model": "numpy", "nogil": True, "cache": True}
"""No fast maths: nothing is fused or summed in another order."""
SWEEPS = 60
"""More than Jacobi's rotations ever need; they converge quadratically."""
NEGLIGIBLE = 1e-17


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a b, of matrices or vectors, each sum from first to last."""
    product = _multiply(_as_matrix(a.reshape(-1, a.shape[-1])), _as_matrix(_columns(b)))
    return product.reshape(a.shape[:-1] + b.shape[1:])


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x of matrix x = right, (n,) or (n, m), by Gauss with partial pivoting."""
    return _eliminate(_as_matrix(matrix).copy(), _columns(right).copy()).reshape(right.shape)


def eigh(matrix: np.ndarray, mass: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues x, ascending, and eigenvectors v, the columns, of matrix v = x mass v.

    matrix: (n, n), symmetric; mass: (n, n), positive definite, the identity if left out
    v.mass v = 1, and each vector's largest component is positive.
    """
    lower = np.eye(len(matrix)) if mass is None else _cholesky(_as_matrix(mass))
    half = solve(lower, np.asarray(matrix, float))
    values, vectors = _jacobi(_as_matrix(solve(lower, half.T)))
    vectors = solve(_as_matrix(lower.T), vectors)
    largest = np.take_along_axis(vectors, np.abs(vectors).argmax(axis=0)[np.newaxis], axis=0)
    vectors = np.where(largest < 0, -vectors, vectors)
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def _as_matrix(values):
    return np.ascontiguousarray(values, dtype=float)


def _columns(right):
    return _as_matrix(right.reshape(len(right), -1))


@njit(**PLAIN)
def _multiply(a, b):
    product = np.zeros((a.shape[0], b.shape[1]))
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            for j in range(b.shape[1]):
                product[i, j] += a[i, k] * b[k, j]
    return product


@njit(**PLAIN)
def _eliminate(matrix, right):
    """Gauss with partial pivoting; both arguments are modified in place."""
    n = len(matrix)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(right.shape[1]):
                right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                for j in range(right.shape[1]):
                    right[i, j] -= factor * right[k, j]
    for i in range(n - 1, -1, -1):
        for j in range(right.shape[1]):
            for k in range(i + 1, n):
                right[i, j] -= matrix[i, k] * right[k, j]
            right[i, j] /= matrix[i, i]
    return right


@njit(**PLAIN)
def _cholesky(matrix):
    """L of L L^T = matrix; not finite if the matrix is not positive definite."""
    n = len(matrix)
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            lower[i, j] = np.sqrt(rest) if i == j else rest / lower[j, j]
    return lower


@njit(**PLAIN)
def _jacobi(matrix):
    """Eigenvalues and eigenvectors, the columns, by cyclic rotations (Golub & Van Loan, 8.5).

    Only the upper triangle is read.
    """
    n = len(matrix)
    a, vectors = matrix.copy(), np.eye(n)  # vectors: the rows, until the end
    for i in range(n):
        for j in range(i):
            a[i, j] = a[j, i]
    for _ in range(SWEEPS):
        rotated = False
        for p in range(n - 1):
            for q in range(p + 1, n):
                if not abs(a[p, q]) > NEGLIGIBLE * np.sqrt(abs(a[p, p])) * np.sqrt(abs(a[q, q])):
                    continue
                rotated = True
                slope = (a[q, q] - a[p, p]) / (2 * a[p, q])
                t = (1.0 if slope >= 0 else -1.0) / (abs(slope) + np.sqrt(slope * slope + 1))
                c = 1 / np.sqrt(t * t + 1)
                s = t * c
                shift = t * a[p, q]
                a_pp, a_qq = a[p, p] - shift, a[q, q] + shift
                for k in range(n):
                    above, below = a[p, k], a[q, k]
                    a[p, k], a[q, k] = c * above - s * below, s * above + c * below
                    above, below = vectors[p, k], vectors[q, k]
                    vectors[p, k], vectors[q, k] = c * above - s * below, s * above + c * below
                for k in range(n):
                    a[k, p], a[k, q] = a[p, k], a[q, k]
                a[p, p], a[q, q], a[p, q], a[q, p] = a_pp, a_qq, 0.0, 0.0
        if not rotated:
            break
    return np.diag(a).copy(), vectors.T.copy()
