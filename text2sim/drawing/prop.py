"""Props of a picture and their triangles."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Prop:
    """The triangles of one colour of a copy of a body or static."""

    name: str
    """Name of the copy: `brick[3]`."""
    body: str
    """Name of the body or static: `brick`."""
    triangles: np.ndarray
    """Triangles [m] in the world frame, counterclockwise from outside, (n, 3, 3) float."""
    rgb: tuple[float, float, float]
    opacity: float
    moves: bool
    """Whether it can move."""
    finish: str
    """Finish of the language."""
    plane: bool
    """Whether it is an infinite ground."""
    static: bool
    """Whether it is in the section `scene`."""


@dataclass(frozen=True, eq=False)
class Stage:
    """The props of a case, and all their triangles."""

    props: list[Prop]
    triangles: np.ndarray
    """Triangles [m], (n, 3, 3) float."""
    normals: np.ndarray
    """Unit normals at the corners, (n, 3, 3) float32."""
    colors: np.ndarray
    """Colours in 0..1, (n, 3) float32."""
    owner: np.ndarray
    """Index of the prop, (n,) int32."""
    culled: np.ndarray
    """Whether the triangle is only visible from outside, (n,) bool."""

    def __iter__(self) -> Iterator[Prop]:
        return iter(self.props)

    def __len__(self) -> int:
        return len(self.props)

    @property
    def grounds(self) -> np.ndarray:
        """Whether the triangle belongs to an infinite ground, (n,) bool."""
        return np.array([prop.plane for prop in self.props], bool)[self.owner]
