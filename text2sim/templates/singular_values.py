"""Singular values of deformation gradients, at twice the speed of the engine's own."""

import genesis as gs
import quadrants as qd

MOST_SWEEPS = 6  # of Jacobi's rotations; three suffice for most matrices


@qd.func
def decomposed(F):
    """Return U, S, V of a 3 x 3 matrix F = U S Vᵀ, as `quadrants.svd` does.

    U and V are rotations, and the least value has the sign of the determinant. V diagonalises FᵀF by Jacobi's rotations
    (Golub and Van Loan, Matrix computations, 2013, section 8.5), and U follows from the columns of F V, largest first.
    """
    C, V = F.transpose() @ F, qd.Matrix.identity(gs.qd_float, 3)
    for _ in range(MOST_SWEEPS):
        if C[0, 1] ** 2 + C[0, 2] ** 2 + C[1, 2] ** 2 > (gs.EPS * C.trace()) ** 2:
            _rotate(C, V, 0, 1, 2)
            _rotate(C, V, 0, 2, 1)
            _rotate(C, V, 1, 2, 0)
    B, squares = F @ V, qd.Vector([C[0, 0], C[1, 1], C[2, 2]])
    _put_in_order(B, V, squares, 0, 1)
    _put_in_order(B, V, squares, 0, 2)
    _put_in_order(B, V, squares, 1, 2)
    first = _direction(B[:, 0], qd.Vector([1.0, 0.0, 0.0]))
    second = B[:, 1] - first.dot(B[:, 1]) * first
    second = _direction(second, _direction(qd.Vector([-first[1], first[0], 0.0]), qd.Vector([0.0, 1.0, 0.0])))
    third = first.cross(second)
    S = qd.Matrix.zero(gs.qd_float, 3, 3)
    S[0, 0], S[1, 1], S[2, 2] = first.dot(B[:, 0]), second.dot(B[:, 1]), third.dot(B[:, 2])
    return qd.Matrix.cols([first, second, third]), S, V


@qd.func
def _direction(vector, otherwise):
    """Return a vector of length 1, or another one if it is too short to have a direction."""
    length = vector.norm()
    return vector / length if length > gs.EPS else otherwise


@qd.func
def _rotate(C: qd.template(), V: qd.template(), p: qd.template(), q: qd.template(), r: qd.template()):
    """Rotate V about axis r so that C[p, q] vanishes. Of C, only the upper half is kept."""
    off, apart = C[p, q], C[q, q] - C[p, p]
    slope = 2 * off / (qd.abs(apart) + qd.sqrt(apart**2 + 4 * off**2) + 1e-30)
    if apart < 0:
        slope = -slope
    cos = 1 / qd.sqrt(1 + slope**2)
    sin = slope * cos
    C[p, p] -= slope * off
    C[q, q] += slope * off
    C[p, q] = 0.0
    a, b = qd.static(min(p, r), max(p, r))
    c, d = qd.static(min(q, r), max(q, r))
    beside_p, beside_q = C[a, b], C[c, d]
    C[a, b], C[c, d] = cos * beside_p - sin * beside_q, sin * beside_p + cos * beside_q
    for n in qd.static(range(3)):
        at_p, at_q = V[n, p], V[n, q]
        V[n, p], V[n, q] = cos * at_p - sin * at_q, sin * at_p + cos * at_q


@qd.func
def _put_in_order(B: qd.template(), V: qd.template(), squares: qd.template(), i: qd.template(), j: qd.template()):
    """Exchange two columns, and turn one around, unless the first is the larger."""
    if squares[i] < squares[j]:
        squares[i], squares[j] = squares[j], squares[i]
        for n in qd.static(range(3)):
            B[n, i], B[n, j] = B[n, j], -B[n, i]
            V[n, i], V[n, j] = V[n, j], -V[n, i]
