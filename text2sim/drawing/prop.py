"""Props of a picture and their triangles."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

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
class Stage(Sequence[Prop]):
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

    @overload
    def __getitem__(self, index: int) -> Prop: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Prop]: ...
    def __getitem__(self, index: int | slice) -> Prop | Sequence[Prop]:
        return self.props[index]

    def __len__(self) -> int:
        return len(self.props)

    def of(self, *, plane: bool | None = None, opaque: bool | None = None) -> np.ndarray:
        """Return the indices of triangles of props with these properties."""
        wanted = [
            (plane is None or prop.plane == plane) and (opaque is None or (prop.opacity >= 1.0) == opaque)
            for prop in self.props
        ]
        return np.flatnonzero(np.array(wanted, bool)[self.owner]) if wanted else np.zeros(0, np.int64)
