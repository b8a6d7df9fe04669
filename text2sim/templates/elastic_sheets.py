"""Elastic sheets: cloth whose threads stretch as a material does, such as rubber, and may be stretched at the start."""

import numpy as np

APART = 50.0
"""Distance [m] by which places at rest of different sheets are apart: see `stretch`."""


def stretch(bodies, rows):
    """Give cloth the stiffness of a material, and the lengths of threads at rest that it has before it is stretched.

    In every substep h the engine corrects a thread K times by a part w of its error, as far as masses m1 and m2 and its
    compliance c allow: it pulls with `K w / (h^2 (1/m1 + 1/m2) + c)` [N/m], and c is chosen so that this is what the
    material has. A net of equal triangles of area A is as stiff as a sheet of tension modulus E t and Poisson's ratio
    1/3 if its threads of length l have `E t A / l^2` from each triangle beside them, at rest (Ostoja-Starzewski,
    Lattice models in micromechanics, 2002).

    Cloth touches itself only where its points are farther apart at rest than the size of a particle. So places at rest
    are drawn together, too, and those of each sheet are moved away from all others.

    Args:
        bodies: The bodies by name, after the scene was built.
        rows: By name of a sheet: its tension modulus E t [N/m]; length over length at rest of its threads at the start;
            direction in which they are not stretched, (x, y, z) in the world, or None.
    """
    solver = bodies[next(iter(rows))].solver
    edges, points = solver.edges_info, solver.particles_info
    ends = np.stack([edges.v1.to_numpy(), edges.v2.to_numpy()], axis=1)
    places = solver.particles.pos.to_numpy()[:, 0].astype(float)
    masses = points.mass.to_numpy().astype(float)
    lengths, compliances = edges.len_rest.to_numpy(), edges.stretch_compliance.to_numpy()
    sweeps = solver._max_stretch_solver_iterations * edges.stretch_relaxation.to_numpy()
    rest = points.pos_rest.to_numpy()
    for number, (name, (modulus, ratio, across)) in enumerate(rows.items(), 1):
        body = bodies[name]
        first, last = body.particle_start, body.particle_end
        own = (ends[:, 0] >= first) & (ends[:, 0] < last)
        at, faces = places[first:last], np.asarray(body.mesh.faces)
        lengths[own] = at_rest(at, ends[own] - first, ratio, across)
        sides = np.stack([at_rest(at, faces[:, pair], ratio, across) for pair in ([0, 1], [1, 2], [2, 0])], axis=1)
        wanted = modulus * beside(ends[own] - first, faces, sides) / lengths[own] ** 2
        slack = solver.substep_dt**2 * (1 / masses[ends[own]]).sum(axis=1)
        compliances[own] = np.maximum(sweeps[own] / np.maximum(wanted, 1e-9) - slack, 0.0)
        rest[first:last] = places[first:last] / ratio + (APART * number, 0.0, 0.0)
    edges.len_rest.from_numpy(lengths)
    edges.stretch_compliance.from_numpy(compliances)
    points.pos_rest.from_numpy(rest.astype(np.float32))


def at_rest(places, pairs, ratio, across):
    """Return the length at rest [m] between each pair of points, (n,).

    Args:
        places: Places of the points at the start [m], (p, 3).
        pairs: Numbers of two points each, (n, 2).
        ratio: Length over length at rest.
        across: Direction in which it is not stretched, or None.
    """
    apart = places[pairs[:, 1]] - places[pairs[:, 0]]
    kept = (apart @ np.array(across)) ** 2 if across is not None else 0.0
    return np.sqrt(((apart**2).sum(axis=1) - kept) / ratio**2 + kept)


def beside(threads, faces, sides):
    """Return the area [m2] of the triangles beside each thread, (n,).

    Args:
        threads: Numbers of the ends of threads, (n, 2).
        faces: Numbers of the corners of triangles, (f, 3).
        sides: Lengths of their sides [m], (f, 3).
    """
    half = sides.sum(axis=1) / 2
    areas = np.sqrt(np.maximum(half * (half[:, None] - sides).prod(axis=1), 0.0))  # Heron
    pairs = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys, index = np.unique(pairs, axis=0, return_inverse=True)
    sums = np.bincount(index.ravel(), np.repeat(areas, 3), len(keys))
    number = dict(zip(map(tuple, keys.tolist()), sums.tolist(), strict=True))
    return np.array([number.get(tuple(sorted(thread)), 0.0) for thread in threads.tolist()])
