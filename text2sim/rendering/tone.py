"""Tone mapping from radiance to the displayed picture: gain, tone curve, background.

AgX is Troy Sobotka's; the polynomial of its curve and the matrices are Benjamin Wrensch's
(https://iolite-engine.com/blog_posts/minimal_agx_implementation). ACES is Stephen Hill's fit.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

ROWS = 32
"""Rows of a picture that are developed at a time: as many as fit into a cache."""

AGX_IN = np.array([
    [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
    [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
    [0.0423756549057051, 0.0784336, 0.879142973793104],
])  # fmt: skip
AGX_OUT = np.linalg.inv(AGX_IN)
AGX_LOW, AGX_HIGH = -12.47393, 4.026069
"""Lower and upper end of the tone curve, as powers of two."""
AGX_CURVE = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)
CONTRAST, SATURATION = 1.3, 1.14
"""Contrast and saturation of the grading, a milder form of AgX's "punchy" look: AgX alone is meant to be graded."""
KEPT, KEPT_LESS = 0.9, 0.6
"""Share of the light's own chromaticity that black keeps, and by how much white keeps less of it. Curves of single
channels make lights pale, as film does, but shadows garish: brown wood becomes orange, dark green glows."""
AGX_GAIN = 2.0
"""Exposure before AgX: a fully lit white sheet is displayed as 83 % of white, with three stops above it."""
ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
ACES_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
LUMA = np.array([0.2126, 0.7152, 0.0722])


def developed(radiance: Array, gain: float, tone: str) -> Array:
    """Return radiance (h, w, 3), linear Rec. 709, as a picture in sRGB, 0 to 1.

    Args:
        radiance: Radiance at the camera, shape (h, w, 3).
        gain: Factor that maps a lit white sheet to 1.
        tone: agx, aces or standard.
    """
    with ThreadPoolExecutor() as pool:
        parts = [radiance[k : k + ROWS] for k in range(0, len(radiance), ROWS)]
        return np.concatenate(list(pool.map(lambda part: _developed(part, gain, tone), parts)))


def _developed(radiance: Array, gain: float, tone: str) -> Array:
    light = np.maximum(np.nan_to_num(radiance, posinf=1e4), 0.0) * gain
    if tone == "agx":
        return _agx(light * AGX_GAIN)
    if tone == "aces":
        light = light @ ACES_IN.T
        light = (light * (light + 0.0245786) - 0.000090537) / (light * (0.983729 * light + 0.4329510) + 0.238081)
        return encoded(np.clip(light @ ACES_OUT.T, 0.0, 1.0))
    return encoded(np.clip(light, 0.0, 1.0))


def encoded(linear: Array) -> Array:
    """Convert linear values to sRGB."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def linear(srgb: Array) -> Array:
    """Convert sRGB values, 0 to 1, to linear ones."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def over(picture: Array, alpha: Array, color: tuple[float, float, float] | Array) -> Array:
    """Composite a picture (h, w, 3) over a plain colour or another picture, both in sRGB, by its alpha.

    Args:
        picture: The picture, shape (h, w, 3), sRGB.
        alpha: Its alpha, shape (h, w), 0 to 1.
        color: The colour, or another picture, shape (h, w, 3), sRGB.
    """
    return picture * alpha[..., None] + np.asarray(color) * (1 - alpha[..., None])


def bytes_of(picture: Array) -> NDArray[np.uint8]:
    """Quantise a picture from 0 to 1 to uint8."""
    return (np.clip(picture, 0.0, 1.0) * 255 + 0.5).astype(np.uint8)


def _agx(light: Array) -> Array:
    log = np.log2(np.maximum(light @ AGX_IN.T, 1e-10))
    x = np.clip((log - AGX_LOW) / (AGX_HIGH - AGX_LOW), 0.0, 1.0)
    shown = np.polyval(AGX_CURVE, x)
    shown = np.maximum(shown, 0.0) ** CONTRAST
    grey = (shown @ LUMA)[..., None]
    shown = grey + SATURATION * (shown - grey)
    # The curve's result is already encoded for display.
    graded = np.maximum(shown @ AGX_OUT.T, 0.0) ** 2.2
    bright = (graded @ LUMA)[..., None]
    own = light * (bright / np.maximum(light @ LUMA, 1e-9)[..., None]) - bright
    own = bright + own / np.maximum((own / np.maximum(1 - bright, 1e-6)).max(-1, keepdims=True), 1.0)
    kept = np.clip(KEPT - KEPT_LESS * encoded(bright), 0.0, 1.0)
    return encoded(np.clip(graded + kept * (own - graded), 0.0, 1.0))
