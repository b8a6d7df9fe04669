"""Principal stretches of mpm particles, with which an isotropic material needs no singular value decomposition.

The engine decomposes every deformation gradient as `F = U S V^T`. Its laws depend on S and U alone: the square roots of
the eigenvalues of `F F^T`, and its eigenvectors, which are half the work. The engine hands the S that a material's
`update_F_S_Jp` returns on to its `update_stress`, and to nothing else; a law that uses this module returns Kirchhoff's
stress there.
"""

import genesis as gs
import quadrants as qd

TOLERANCE = 1e-13
"""Ratio of squares of the elements beside the diagonal and on it that counts as rounding."""
MAX_SWEEPS = 6
"""Largest number of sweeps. Three are common."""


@qd.func
def principal(gradient):
    """Return the directions and sizes of the principal stretches of a deformation gradient F.

    The cyclic method of Jacobi (Golub and Van Loan, Matrix Computations, 8.5), for `F F^T - 1`, which keeps the digits
    of small strains. The least stretch of what is inside out is negative, as in the engine.

    Returns:
        axes (3, 3): Directions, as columns.
        stretches (3,): Their stretches.
    """
    strain = gradient - qd.Matrix.identity(gs.qd_float, 3)
    e = strain + strain.transpose() + strain @ strain.transpose()
    axes = qd.Matrix.identity(gs.qd_float, 3)
    for _ in range(MAX_SWEEPS):
        beside = e[0, 1] ** 2 + e[0, 2] ** 2 + e[1, 2] ** 2
        if beside > TOLERANCE * (e[0, 0] ** 2 + e[1, 1] ** 2 + e[2, 2] ** 2):
            for p, q in qd.static(((0, 1), (0, 2), (1, 2))):
                if e[p, q] != 0.0:
                    r = qd.static(3 - p - q)
                    ratio = (e[q, q] - e[p, p]) / (2.0 * e[p, q])
                    tangent = (1.0 if ratio >= 0.0 else -1.0) / (abs(ratio) + qd.sqrt(ratio * ratio + 1.0))
                    cosine = 1.0 / qd.sqrt(tangent * tangent + 1.0)
                    sine = tangent * cosine
                    e[p, p] -= tangent * e[p, q]
                    e[q, q] += tangent * e[p, q]
                    e[p, q] = 0.0
                    e[q, p] = 0.0
                    erp, erq = e[r, p], e[r, q]
                    e[r, p], e[r, q] = cosine * erp - sine * erq, sine * erp + cosine * erq
                    e[p, r], e[q, r] = e[r, p], e[r, q]
                    for k in qd.static(range(3)):
                        along, across = axes[k, p], axes[k, q]
                        axes[k, p], axes[k, q] = cosine * along - sine * across, sine * along + cosine * across
    stretches = qd.Vector.zero(gs.qd_float, 3)
    for k in qd.static(range(3)):
        stretches[k] = qd.sqrt(max(1.0 + e[k, k], 0.0))
    if gradient.determinant() < 0.0:
        least = min(stretches[0], stretches[1], stretches[2])
        for k in qd.static(range(3)):
            if stretches[k] == least:
                stretches[k] = -least
                least = -1.0  # that of one direction only
    return axes, stretches


@qd.func
def tensor_along(axes, values):
    """Return the symmetric tensor with the given principal values, (3, 3)."""
    diagonal = qd.Matrix.zero(gs.qd_float, 3, 3)
    for k in qd.static(range(3)):
        diagonal[k, k] = values[k]
    return axes @ diagonal @ axes.transpose()


@qd.func
def restretched(gradient, axes, old, new):
    """Return a deformation gradient with other principal stretches, (3, 3), in the same directions."""
    ratios = qd.Vector.zero(gs.qd_float, 3)
    for k in qd.static(range(3)):
        ratios[k] = new[k] / (old[k] if abs(old[k]) > gs.EPS else gs.EPS)
    return tensor_along(axes, ratios) @ gradient


@qd.func
def corotated_stress(axes, stretches, mu, lam, volume):
    """Return Kirchhoff's stress of the corotated model [Pa], (3, 3).

    Args:
        axes: Directions of the principal stretches.
        stretches: Their sizes.
        mu: Shear modulus [Pa].
        lam: Lamé's first parameter [Pa].
        volume: Ratio of volumes J.
    """
    values = qd.Vector.zero(gs.qd_float, 3)
    for k in qd.static(range(3)):
        values[k] = 2.0 * mu * (stretches[k] - 1.0) * stretches[k] + lam * volume * (volume - 1.0)
    return tensor_along(axes, values)
