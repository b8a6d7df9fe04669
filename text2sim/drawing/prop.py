"""Triangles of a picture, and whose they are."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np


@dataclass(frozen=True, eq=False)
class Prop:
    """What is drawn in one colour of one copy of a body or static."""

    name: str
    """Name of the copy: `brick[3]`."""
    body: str
    """Name of the body or static: `brick`."""
    triangles: np.ndarray
    """(n, 3, 3) float [m], in the world; counterclockwise from outside"""
    rgb: tuple[float, float, float]
    opacity: float
    moves: bool
    """Whether anything lets it move."""
    finish: str
    """Surface, as in the language."""
    plane: bool
    """Whether it is a ground without end."""
    static: bool
    """Whether it stands in the section `scene`."""


@dataclass(frozen=True, eq=False)
class Stage(Sequence[Prop]):
    """The props of a case, and all their triangles in one row."""

    props: list[Prop]
    triangles: np.ndarray
    """(n, 3, 3) float [m]"""
    normals: np.ndarray
    """(n, 3, 3) float32, unit length, at the corners"""
    colors: np.ndarray
    """(n, 3) float32, each channel in 0..1"""
    owner: np.ndarray
    """(n,) int32: number of the prop"""
    culled: np.ndarray
    """(n,) bool: seen from outside only"""

    @overload
    def __getitem__(self, index: int) -> Prop: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Prop]: ...
    def __getitem__(self, index: int | slice) -> Prop | Sequence[Prop]:
        return self.props[index]

    def __len__(self) -> int:
        return len(self.props)

    def of(self, *, plane: bool | None = None, opaque: bool | None = None) -> np.ndarray:
        """Return the numbers of triangles of certain props."""
        wanted = [
            (plane is None or prop.plane == plane) and (opaque is None or (prop.opacity >= 1.0) == opaque)
            for prop in self.props
        ]
        return np.flatnonzero(np.array(wanted, bool)[self.owner]) if wanted else np.zeros(0, np.int64)
