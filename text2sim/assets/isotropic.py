"""Isotropic remeshing of a surface (Botsch and Kobbelt, 2004), as Genesis does it for its own bodies.

In a process with much freed memory the library gives the same surface other triangles at times, as if it read memory
that it has not set. Whoever needs the same ones calls this in a new process (`confined.call_in_child`).
"""

import numpy as np

ITERATIONS = 6


def remesh_isotropically(
    vertices: np.ndarray, faces: np.ndarray, edge: float, feature_deg: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return a surface with triangles of one size.

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3) int.
        edge: Wanted length of edges [m].
        feature_deg: Edges that are bent by more than this stay.
    """
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)  # type: ignore[attr-defined]
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=vertices, face_matrix=faces))  # type: ignore[attr-defined]
    meshes.meshing_isotropic_explicit_remeshing(
        targetlen=pymeshlab.PureValue(edge),  # type: ignore[attr-defined]
        iterations=ITERATIONS,
        featuredeg=feature_deg,
    )
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()
