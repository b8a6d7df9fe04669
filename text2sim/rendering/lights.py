"""Emitters of the path tracer for the lights of a film. Strengths are irradiances [W/m2] or intensities [W/sr].

Lamps have an area: a sun is a distant disc, a lamp a sphere. So shadows are soft as in a photograph, and there is
little noise.
"""

from math import atan, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.tone import linear
from text2sim.templates.cameras import basis

Array = NDArray[np.floating]

FAR = 60.0
"""Distance of a sun [m], in radii of the stage."""
CLEAR = 0.82
"""Fraction of the irradiance of a clear day that comes from the sun itself."""
SUN_DISC = radians(1.2)
"""Angular diameter of the sun [rad]: twice the real one, which looks the same and halves the noise at the edges of
shadows."""
ROWS = 32
"""Rows of a sky's texture."""
GROUND = 0.35
"""Brightness below the horizon of a sky, as a fraction of that at the horizon."""


def emitters(lights: dict[str, dict[str, Any]], center: Array, radius: float) -> dict[str, Any]:
    """Return the emitters of a scene, by name.

    Args:
        lights: Resolved lights of the film section.
        center: Centre of the stage [m].
        radius: Radius of the stage [m].
    """
    emitters: dict[str, Any] = {}
    for name, light in lights.items():
        color = _color(light)
        kind = light["kind"]
        if kind == "sun":
            emitters[f"light_{name}"] = _sun(light, color * light["strength"], center, radius)
        elif kind == "softbox":
            emitters[f"light_{name}"] = _softbox(light, color)
        elif kind in ("lamp", "spot"):
            emitters[f"light_{name}"] = _lamp(light, color)
        elif kind == "sky":
            low = abs(light["direction"][2]) / np.linalg.norm(light["direction"])
            warm = np.array([1.0, 0.86 + 0.1 * low, 0.66 + 0.28 * low])
            # The irradiance is that of the ground, which a low sun meets at an angle.
            facing = CLEAR * light["strength"] / max(low, 0.15)
            emitters[f"light_{name}"] = _sun(light | {"angle": SUN_DISC}, color * warm * facing, center, radius)
    radiance = dome_radiance(lights)
    if radiance.any():
        emitters["dome"] = dome(radiance)
    return emitters


def dome_radiance(lights: dict[str, dict[str, Any]]) -> Array:
    """Return the radiance of all light that comes from everywhere, shape (ROWS, 2 ROWS, 3), from zenith to nadir.

    Args:
        lights: Resolved lights of the film section.
    """
    radiance = np.zeros((ROWS, 2 * ROWS, 3))
    for light in lights.values():
        color = _color(light)
        if light["kind"] == "environment":
            radiance += gradient(color, linear(np.asarray(light["horizon"], float))) * light["strength"]
        elif light["kind"] == "sky":
            radiance += _sky(light) * color * (1 - CLEAR) * light["strength"]
    return radiance


def dome(radiance: Array) -> Any:
    """Return an environment map from radiance of shape (ROWS, 2 ROWS, 3), from zenith to nadir."""
    mi = mitsuba()
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    bitmap = mi.Bitmap(np.ascontiguousarray(radiance, np.float32))
    return mi.load_dict({"type": "envmap", "bitmap": bitmap, "to_world": upright})


def _color(light: dict[str, Any]) -> Array:
    """Return the linear colour of a light; white if it has none, as a sky has its own."""
    return linear(np.asarray(light["color"], float)) if "color" in light else np.ones(3)


def box_irradiance(size: float, distance: float) -> float:
    """Return the irradiance [W/m2] at a distance [m] on the axis of a facing square of radiance 1 and this size [m]."""
    a = size / 2 / distance
    root = sqrt(1 + a * a)
    return 4 * a / root * atan(a / root)


def _sun(light: dict[str, Any], irradiance: Array, center: Array, radius: float) -> Any:
    direction = np.asarray(light["direction"], float) / np.linalg.norm(light["direction"])
    half = max(light["angle"], 0.002) / 2
    away = FAR * radius
    return _facing(
        {"type": "disk"}, center - away * direction, center, away * tan(half), irradiance / (pi * sin(half) ** 2)
    )


def _softbox(light: dict[str, Any], color: Array) -> Any:
    direction = np.asarray(light["direction"], float) / np.linalg.norm(light["direction"])
    at = np.asarray(light["at"], float)
    radiance = color * light["strength"] / box_irradiance(light["size"], light["distance"])
    return _facing({"type": "rectangle"}, at - light["distance"] * direction, at, light["size"] / 2, radiance)


def _facing(shape: dict[str, Any], pos: Array, target: Array, scale: float, radiance: Array) -> Any:
    """Return a flat emitter from a shape of width 2 that faces +z, rotated and scaled."""
    mi = mitsuba()
    right, up, ahead = basis(pos, target, (0.0, 0.0, 1.0))
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([up, right, ahead], axis=1) * (scale, scale, 1.0)
    matrix[:3, 3] = pos
    return mi.load_dict(shape | {"to_world": mi.ScalarTransform4f(matrix), "emitter": _area(radiance)})


def _lamp(light: dict[str, Any], color: Array) -> Any:
    mi, intensity = mitsuba(), color * light["strength"]
    pos = [float(x) for x in light["pos"]]
    if light["kind"] == "spot":
        half = np.degrees(light["angle"]) / 2
        pose = mi.ScalarTransform4f().look_at(pos, [float(x) for x in light["look_at"]], _upright(light))
        return mi.load_dict({
            "type": "spot", "to_world": pose, "cutoff_angle": float(half),
            "beam_width": float(half * min(1 - light["blur"], 0.99)),
            "intensity": {"type": "rgb", "value": intensity.tolist()},
        })  # fmt: skip
    radius = float(light["radius"])
    return mi.load_dict({
        "type": "sphere", "center": pos, "radius": radius, "emitter": _area(intensity / (pi * radius**2)),
    })  # fmt: skip


def _upright(light: dict[str, Any]) -> list[float]:
    direction = np.subtract(light["look_at"], light["pos"])
    return [0.0, 1.0, 0.0] if np.hypot(direction[0], direction[1]) < 1e-3 * abs(direction[2]) else [0.0, 0.0, 1.0]


def _area(radiance: Array) -> dict[str, Any]:
    return {"type": "area", "radiance": {"type": "rgb", "value": [float(x) for x in radiance]}}


def gradient(above: Array, horizon: Array) -> Array:
    """Return the radiance of a dome with a gradient from the colour above to that at the horizon.

    Its shape is (ROWS, 2 ROWS, 3), from zenith to nadir.
    """
    height = np.cos((np.arange(ROWS) + 0.5) * pi / ROWS)[:, None]
    upper = horizon + (above - horizon) * np.clip(height, 0, 1) ** 0.6
    lower = horizon * (1 - (1 - GROUND) * np.clip(-6 * height, 0, 1))
    return np.broadcast_to(np.where(height > 0, upper, lower)[:, None], (ROWS, 2 * ROWS, 3))


def _sky(light: dict[str, Any]) -> Array:
    """Return the radiance of a clear sky without the sun, scaled to an irradiance of 1 on the ground."""
    mi = mitsuba()
    direction = np.asarray(light["direction"], float) / np.linalg.norm(light["direction"])
    sky = mi.load_dict({
        "type": "sunsky", "sun_scale": 0.0, "sun_direction": [float(-x) for x in direction],
        "turbidity": float(light["turbidity"]), "to_world": mi.ScalarTransform4f(),
    })  # fmt: skip
    polar = (np.arange(ROWS) + 0.5) * pi / ROWS
    turn = (np.arange(2 * ROWS) + 0.5) * pi / ROWS
    found = np.zeros((ROWS, 2 * ROWS, 3))
    for i, theta in enumerate(polar[: ROWS // 2]):
        for j, phi in enumerate(turn):
            # Texels of an upright envmap begin at -y and proceed towards -x.
            ray = (-np.sin(theta) * np.sin(phi), np.sin(theta) * np.cos(phi), np.cos(theta))
            point = mi.SurfaceInteraction3f()
            point.wi = [float(-x) for x in ray]
            found[i, j] = np.array(sky.eval(point)).ravel()[:3]
    weight = (np.cos(polar) * np.sin(polar) * (pi / ROWS) ** 2)[: ROWS // 2, None, None]
    irradiance = float((found[: ROWS // 2].mean(axis=-1, keepdims=True) * weight).sum())
    found /= max(irradiance, 1e-9)
    found[ROWS // 2 :] = found[ROWS // 2 - 1].mean(axis=0) * GROUND
    return found
