"""Shading of surface points under lamps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from text2sim.drawing.lighting import ParallelLight, ShadowMap

# Strength and exponent of highlights, and the metallic part, by finish.
GLOSS: dict[str, tuple[float, float, float]] = {
    "rough": (0.0, 8.0, 0.0),
    "painted": (0.15, 30.0, 0.0),
    "plastic": (0.25, 40.0, 0.0),
    "smooth": (0.35, 80.0, 0.0),
    "metal": (0.6, 45.0, 0.75),
    "brushed_metal": (0.5, 25.0, 0.75),
    "polished_metal": (0.7, 120.0, 0.75),
    "concrete": (0.0, 8.0, 0.0),
    "wood": (0.05, 16.0, 0.0),
    "rubber": (0.06, 12.0, 0.0),
    "glass": (0.6, 120.0, 0.0),
    "ceramic": (0.45, 90.0, 0.0),
    "brick": (0.0, 8.0, 0.0),
    "frosted_glass": (0.3, 20.0, 0.0),
    "cloth": (0.0, 8.0, 0.0),
    "silicone": (0.12, 20.0, 0.0),
    "paper": (0.0, 8.0, 0.0),
    "sand": (0.0, 8.0, 0.0),
    "cardboard": (0.0, 8.0, 0.0),
    "leather": (0.1, 16.0, 0.0),
    "felt": (0.0, 8.0, 0.0),
    "plaster": (0.04, 6.0, 0.0),
    "marble": (0.35, 70.0, 0.0),
    "jelly": (0.5, 90.0, 0.0),
    "peel": (0.2, 24.0, 0.0),
    "foliage": (0.0, 8.0, 0.0),
    "bark": (0.0, 8.0, 0.0),
    "fur": (0.0, 8.0, 0.0),
    "crust": (0.12, 20.0, 0.0),
    "stone": (0.0, 8.0, 0.0),
}


@dataclass(frozen=True, eq=False)
class Spots:
    """Visible surface points. Vectors are columns."""

    points: np.ndarray
    """Positions [m], (3, n) float32."""
    normals: np.ndarray
    """Unit normals towards the eye, (3, n) float32, or (3, 1) if all are equal."""
    eye: np.ndarray
    """Unit vectors towards the eye, (3, n) float32."""
    albedo: np.ndarray
    """Reflected part of the light, linear, (3, n) float32."""
    gloss: np.ndarray
    """Rows of `GLOSS`, (3, n) float32."""


def linear(color: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return sRGB as linear light, approximately."""
    return np.asarray(color, np.float32) ** np.float32(2.2)


KNEE, HEADROOM = np.float32(0.7), np.float32(0.6)


def encoded(light: np.ndarray) -> np.ndarray:
    """Return linear light as sRGB, compressed above `KNEE`, so that highlights keep some colour."""
    over = np.maximum(light - KNEE, 0.0)
    bent = np.minimum(light, KNEE) + over / (1 + over / HEADROOM)
    return np.clip(bent, 0.0, 1.0) ** np.float32(1 / 2.2)


def decoded(color: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return the linear light of a colour in sRGB: the inverse of `encoded`."""
    straight = linear(color)
    over = np.maximum(straight - KNEE, 0.0)
    return np.minimum(straight, KNEE) + over / (1 - over / HEADROOM)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the dot products of columns."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit_columns(vectors: np.ndarray) -> np.ndarray:
    """Normalise columns in place."""
    vectors /= np.maximum(np.sqrt(dot(vectors, vectors)), np.float32(1e-9))
    return vectors


def lit(spots: Spots, lamps: Sequence[ParallelLight], maps: Sequence[ShadowMap | None], ambient: float) -> np.ndarray:
    """Return the light (3, n) from points to the eye, linear.

    Args:
        spots: The points.
        lamps: The lamps.
        maps: Shadow map of each lamp, None if nothing blocks it; empty if there are no shadows.
        ambient: Ambient light.
    """
    directions = np.array([lamp.direction for lamp in lamps], np.float32).reshape(-1, 3)
    colors = np.array([lamp.color for lamp in lamps], np.float32).reshape(-1, 3)
    count = spots.points.shape[1]
    facing = np.maximum(directions @ spots.normals, 0.0)
    if facing.shape[1] != count:
        facing = np.repeat(facing, count, axis=1)
    for row, shadows in zip(facing, maps, strict=False):
        towards = np.flatnonzero(row > 0) if shadows is not None else ()
        if shadows is None or not len(towards):
            continue
        if len(towards) > 0.6 * count:
            row *= shadows.reached(spots.points, spots.normals)
        else:
            row[towards] *= shadows.reached(spots.points[:, towards], spots.normals[:, towards])
    diffuse = colors.T @ facing
    diffuse += np.float32(ambient)
    shiny = np.flatnonzero(spots.gloss[0] > 0) if spots.gloss.shape[1] == count else np.zeros(0, np.int64)
    if not len(shiny):
        return diffuse * spots.albedo
    light = diffuse * spots.albedo
    light[:, shiny] = _glossy(spots, shiny, lamps, facing, diffuse)
    return light


def _glossy(
    spots: Spots, shiny: np.ndarray, lamps: Sequence[ParallelLight], facing: np.ndarray, diffuse: np.ndarray
) -> np.ndarray:
    """Light (3, k) of the glossy points."""
    normals, eye, albedo = spots.normals[:, shiny], spots.eye[:, shiny], spots.albedo[:, shiny]
    strength, narrow, metal = spots.gloss[:, shiny]
    glints = np.zeros_like(normals)
    for row, lamp in zip(facing, lamps, strict=True):
        if lamp.glossy:
            half = unit_columns(eye + np.array(lamp.direction, np.float32)[:, None])
            glint = np.maximum(dot(normals, half), 0.0) ** narrow * (row[shiny] > 0) * strength
            glints += np.array(lamp.color, np.float32)[:, None] * glint
    # Reflection of the sky: bright above, dim below.
    slant = np.abs(dot(normals, eye))
    up = 2 * slant * normals[2] - eye[2]
    sky = 0.25 + 0.6 * np.clip(up * 1.5 + 0.35, 0.0, 1.0)
    rim = (sky * (1 - slant) ** 4 * strength * 0.5) * (1 - metal)
    own = diffuse[:, shiny] * (1 - 0.7 * metal) + 0.9 * metal * sky
    return own * albedo + glints * (metal * albedo + (1 - metal)) + rim
