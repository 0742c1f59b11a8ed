"""Small dense matrices by single operations of numpy: the same bits on every machine.

LAPACK and BLAS choose by the processor in which order they sum, and in a chaotic cell the last bit
of a mode shape decides; so whatever feeds a run is computed here. Leading axes, (...), count
matrices, and no result depends on what else is in the same call.
"""

from functools import cache

import numpy as np

SWEEPS = 60
"""More rounds than Jacobi's rotations ever need: they converge quadratically."""
NEGLIGIBLE = 1e-17
"""An element off the diagonal, over the root of both on it, that is not rotated away."""
BLOCK = 512
"""Matrices at work at a time, as many as fit in the cache."""


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a b, (..., n, m), of a, (..., n, k), and b, (..., k, m), each sum from first to last."""
    return sum(a[..., :, k, np.newaxis] * b[..., k, np.newaxis, :] for k in range(a.shape[-1]))


def apply(a: np.ndarray, x: np.ndarray) -> np.ndarray:
    """a x, (..., n), of a, (..., n, k), and x, (..., k)."""
    return sum(a[..., :, k] * x[..., k, np.newaxis] for k in range(a.shape[-1]))


def dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """x . y, (...), of vectors, (..., k)."""
    return sum(x[..., k] * y[..., k] for k in range(x.shape[-1]))


def outer(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """x y^T, (..., n, m), of vectors, (..., n) and (..., m)."""
    return x[..., :, np.newaxis] * y[..., np.newaxis, :]


def solve(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """x of a x = b, (..., n), for a, (..., n, n), and b, (..., n); Gauss with partial pivoting.

    Not finite where a is singular.
    """
    return solve_all(a, b[..., np.newaxis])[..., 0]


def solve_all(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """x of a x = b for several right-hand sides, the columns of b, (..., n, m)."""
    n, m = b.shape[-2:]
    leading = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    sides = [np.broadcast_to(side, (*leading, *side.shape[-2:])) for side in (a, b)]
    equations = _matrices_last(np.concatenate(sides, axis=-1))
    x = np.empty((n, m, equations.shape[-1]))
    for block in _blocks(equations):
        x[..., block] = _eliminate(np.array(equations[..., block], float), n)
    return np.moveaxis(x, -1, 0).reshape(*leading, n, m)


def _blocks(matrices):
    """Slices along the last axis, of as many matrices as are at work at a time."""
    return (slice(i, i + BLOCK) for i in range(0, matrices.shape[-1], BLOCK))


def _matrices_last(a):
    """Put the axes that count matrices into one, the last: numpy's loops run along it."""
    return np.moveaxis(a.reshape(-1, *a.shape[-2:]), 0, -1)


def _eliminate(rows, n):
    """Solutions, (n, m, matrices), of equations, (n, n + m, matrices), which are overwritten."""
    matrix = np.arange(rows.shape[-1])
    for k in range(n):
        pivot = k + np.abs(rows[k:, k]).argmax(axis=0)
        chosen = rows[pivot, :, matrix].T
        rows[pivot, :, matrix] = rows[k].T
        rows[k] = chosen
        factors = rows[k + 1 :, k] / chosen[k]
        rows[k + 1 :, k:] -= factors[:, np.newaxis] * chosen[k:]
    x = rows[:, n:]
    for k in range(n - 1, -1, -1):
        x[k] /= rows[k, k]
        x[:k] -= rows[:k, k, np.newaxis] * x[k]
    return x


def eigh(a: np.ndarray, mass: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues x, ascending, (..., n), and eigenvectors v, the columns, of a v = x mass v.

    a: (..., n, n), symmetric; mass: likewise, positive definite, the identity if left out
    v.mass v = 1, and each vector's largest component is positive.
    """
    if mass is None:
        values, vectors = _rotate(a)
    else:
        lower = _cholesky(mass)
        half = solve_all(lower, a)
        values, vectors = _rotate(solve_all(lower, half.swapaxes(-1, -2)))
        vectors = solve_all(lower.swapaxes(-1, -2), vectors)
    largest = np.abs(vectors).argmax(axis=-2)[..., np.newaxis, :]
    vectors = np.where(np.take_along_axis(vectors, largest, axis=-2) < 0, -vectors, vectors)
    order = np.argsort(values, axis=-1, kind="stable")
    ascending = np.take_along_axis(vectors, order[..., np.newaxis, :], axis=-1)
    return np.take_along_axis(values, order, axis=-1), ascending


def _cholesky(a):
    """L, lower triangular, of L L^T = a; not finite if a is not positive definite."""
    lower, rest = np.zeros(a.shape), np.array(a, float)
    for k in range(a.shape[-1]):
        column = rest[..., k:, k] / np.sqrt(rest[..., k, k, np.newaxis])
        lower[..., k:, k] = column
        rest[..., k:, k:] -= outer(column, column)
    return lower


def eigenvalues(a: np.ndarray) -> np.ndarray:
    """Eigenvalues of symmetric matrices, (..., n, n), ascending, (..., n)."""
    return np.sort(_rotate(a, keep_vectors=False)[0], axis=-1)


def _rotate(a, keep_vectors=True):
    """Eigenvalues and eigenvectors, the columns, by Jacobi's rotations (Golub & Van Loan, 8.5)."""
    *leading, n, _ = a.shape
    matrices = _matrices_last(np.asarray(a))
    values, vectors = np.empty((n, matrices.shape[-1])), np.empty(matrices.shape)
    for block in _blocks(matrices):
        a = np.array(matrices[..., block], float)
        rows = np.repeat(np.eye(n)[..., np.newaxis], a.shape[-1], axis=-1)
        turned = (a, a.swapaxes(0, 1), rows) if keep_vectors else (a, a.swapaxes(0, 1))
        for _ in range(SWEEPS):
            if not any([_rotate_pairs(a, turned, p, q) for p, q in _rounds(n)]):
                break
        values[:, block], vectors[..., block] = np.diagonal(a).T, rows
    values = values.T.reshape(*leading, n)
    return values, np.moveaxis(vectors, -1, 0).swapaxes(-1, -2).reshape(*leading, n, n)


@cache
def _rounds(n):
    """All pairs p < q of n, in rounds in which each comes at most once, as index arrays.

    By the round robin of a tournament: all but the first player move on a seat a round.
    """
    players, rounds = list(range(n + n % 2)), []
    for _ in range(len(players) - 1):
        half = len(players) // 2
        pairs = zip(players[:half], reversed(players[half:]), strict=True)
        rounds.append([sorted(pair) for pair in pairs if max(pair) < n])
        players.insert(1, players.pop())
    return [np.array(pairs).T for pairs in rounds if pairs]


def _rotate_pairs(a, turned, p, q):
    """Make all a_pq of a round zero, in place; returns whether any of them was not.

    a: (n, n, matrices); turned: arrays whose rows p and q are rotated: a, its transpose, vectors
    """
    a_pp, a_qq, a_pq = a[p, p], a[q, q], a[p, q]
    needed = np.abs(a_pq) > NEGLIGIBLE * np.sqrt(np.abs(a_pp)) * np.sqrt(np.abs(a_qq))
    if not needed.any():
        return False
    slope = (a_qq - a_pp) / np.where(needed, 2 * a_pq, 1.0)
    t = np.where(slope < 0, -1.0, 1.0) / (np.abs(slope) + np.sqrt(slope * slope + 1))
    t = np.where(needed, t, 0.0)
    c = (1 / np.sqrt(t * t + 1))[:, np.newaxis]
    s = t[:, np.newaxis] * c
    for rows in turned:
        above, below = rows[p], rows[q]
        rows[p], rows[q] = c * above - s * below, s * above + c * below
    a[p, p], a[q, q] = a_pp - t * a_pq, a_qq + t * a_pq
    a[p, q] = a[q, p] = np.where(needed, 0.0, a_pq)
    return True
