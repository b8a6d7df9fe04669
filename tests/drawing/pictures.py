"""Helpers of the tests of pictures."""

import numpy as np

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.spec_schema.load import load_text

HEAD = """\
text2sim: 2
name: probe
scene: {duration: 1, statics: {floor: {shape: {kind: plane}, pose: {pos: [0, 0, -1]}}}}
bodies:
"""


def resolved(*bodies: str, render: str = "") -> Resolution:
    """A case with these bodies, each a line of YAML."""
    text = HEAD + "".join(f"  {body}\n" for body in bodies)
    return resolve_case(load_text(text + (f"render: {render}\n" if render else "")))


def hits(triangles: np.ndarray, origins: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What lines of sight (n, 3) meet first, tried one triangle at a time: its number (or -1), and how far along."""
    best, which = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for number, (a, b, c) in enumerate(triangles):
        u, v = b - a, c - a
        p = np.cross(ways, v)
        det = p @ u
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.einsum("nk,nk->n", origins - a, p) / det
            q = np.cross(origins - a, u)
            t = np.einsum("nk,nk->n", ways, q) / det
            reach = q @ v / det
            hit = (s >= 0) & (t >= 0) & (s + t <= 1) & (reach > 0.05) & (reach < best)
        best[hit], which[hit] = reach[hit], number
    return which, best


def volume(triangles: np.ndarray) -> float:
    """What a closed surface holds; negative if it is inside out."""
    a, b, c = triangles.transpose(1, 0, 2)
    return float(np.einsum("nk,nk->n", a, np.cross(b, c)).sum() / 6)
