"""Linear algebra of small dense matrices that gives the same bits on every machine.

LAPACK and BLAS choose the order of their sums by the processor, and in a chaotic cell the last bit
of a mode shape decides; so all that feeds a run is computed here, by single operations of numpy.
Leading axes, (...), count matrices; no result depends on the other matrices of a call.
"""

from functools import cache

import numpy as np

SWEEPS = 60
"""Upper bound of the sweeps of Jacobi's rotations, which converge quadratically."""
NEGLIGIBLE = 1e-17
"""Share of sqrt(|a_pp a_qq|) up to which an off-diagonal element a_pq counts as zero."""
BLOCK = 512
"""Number of matrices that are worked on at a time, as they fit in the cache."""


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Multiply a, (..., n, k), by b, (..., k, m), with sums from first to last: (..., n, m)."""
    return sum(a[..., :, k, np.newaxis] * b[..., k, np.newaxis, :] for k in range(a.shape[-1]))


def apply(a: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Multiply matrices a, (..., n, k), by vectors x, (..., k): (..., n)."""
    return sum(a[..., :, k] * x[..., k, np.newaxis] for k in range(a.shape[-1]))


def dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the scalar products, (...), of vectors x and y, (..., k)."""
    return sum(x[..., k] * y[..., k] for k in range(x.shape[-1]))


def outer(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return x y^T, (..., n, m), of vectors x, (..., n), and y, (..., m)."""
    return x[..., :, np.newaxis] * y[..., np.newaxis, :]


def solve(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve a x = b for x, (..., n), by Gauss's elimination with partial pivoting.

    a: (..., n, n), x is not finite where it is singular; b: (..., n)
    """
    return solve_all(a, b[..., np.newaxis])[..., 0]


def solve_all(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve a x = b for x, (..., n, m), with several right-hand sides, the columns of b."""
    n, m = b.shape[-2:]
    leading = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    sides = [np.broadcast_to(side, (*leading, *side.shape[-2:])) for side in (a, b)]
    equations = _matrices_last(np.concatenate(sides, axis=-1))
    x = np.empty((n, m, equations.shape[-1]))
    for block in _blocks(equations):
        x[..., block] = _eliminate(np.array(equations[..., block], float), n)
    return np.moveaxis(x, -1, 0).reshape(*leading, n, m)


def _blocks(matrices):
    """Slice the last axis into blocks of BLOCK matrices."""
    return (slice(i, i + BLOCK) for i in range(0, matrices.shape[-1], BLOCK))


def _matrices_last(a):
    """Join the axes that count matrices to a last one, along which numpy's loops run."""
    return np.moveaxis(a.reshape(-1, *a.shape[-2:]), 0, -1)


def _eliminate(rows, n):
    """Solve equations, (n, n + m, matrices), in place; returns solutions, (n, m, matrices)."""
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
    """Solve a v = x mass v: eigenvalues x, (..., n), ascending, and eigenvectors v, the columns.

    a: (..., n, n), symmetric; mass: (..., n, n), positive definite, None for the identity
    Each v has v.mass v = 1, and its largest component is positive.
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
    """Return the lower triangular L of L L^T = a; not finite if a is not positive definite."""
    lower, rest = np.zeros(a.shape), np.array(a, float)
    for k in range(a.shape[-1]):
        column = rest[..., k:, k] / np.sqrt(rest[..., k, k, np.newaxis])
        lower[..., k:, k] = column
        rest[..., k:, k:] -= outer(column, column)
    return lower


def _rotate(a):
    """Diagonalise symmetric matrices by Jacobi's rotations (Golub & Van Loan, 8.5)."""
    *leading, n, _ = a.shape
    matrices = _matrices_last(np.asarray(a))
    values, vectors = np.empty((n, matrices.shape[-1])), np.empty(matrices.shape)
    for block in _blocks(matrices):
        a = np.array(matrices[..., block], float)
        rows = np.repeat(np.eye(n)[..., np.newaxis], a.shape[-1], axis=-1)
        for _ in range(SWEEPS):
            if not any([_rotate_pairs(a, rows, p, q) for p, q in _rounds(n)]):
                break
        values[:, block], vectors[..., block] = np.diagonal(a).T, rows
    values = values.T.reshape(*leading, n)
    return values, np.moveaxis(vectors, -1, 0).swapaxes(-1, -2).reshape(*leading, n, n)


@cache
def _rounds(n):
    """List all pairs p < q of n indices in rounds, (2, pairs), which use each index at most once.

    As in a tournament's round robin, all but the first player move on by a seat each round.
    """
    players, rounds = list(range(n + n % 2)), []
    for _ in range(len(players) - 1):
        half = len(players) // 2
        pairs = zip(players[:half], reversed(players[half:]), strict=True)
        rounds.append([sorted(pair) for pair in pairs if max(pair) < n])
        players.insert(1, players.pop())
    return [np.array(pairs).T for pairs in rounds if pairs]


def _rotate_pairs(a, vectors, p, q):
    """Rotate the a_pq of a round to zero, in place; returns whether any was above NEGLIGIBLE.

    a: (n, n, matrices); vectors: the rows of which are rotated as those of a and its transpose
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
    for rows in (a, a.swapaxes(0, 1), vectors):
        above, below = rows[p], rows[q]
        rows[p], rows[q] = c * above - s * below, s * above + c * below
    a[p, p], a[q, q] = a_pp - t * a_pq, a_qq + t * a_pq
    a[p, q] = a[q, p] = np.where(needed, 0.0, a_pq)
    return True
