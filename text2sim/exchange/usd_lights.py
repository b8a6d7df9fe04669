"""Export of the film's lights to USD, scaled such that a white sheet is white without exposure."""

from math import degrees, pi
from typing import Any

import numpy as np

from text2sim.exchange.openusd import openusd
from text2sim.exchange.viewing import facing
from text2sim.rendering.lights import CLEAR, box_irradiance
from text2sim.rendering.tone import linear

POINT = 0.01
"""Radius of the source of a spot light [m]."""


def add_lights(stage: Any, at: str, film: dict[str, Any], name_of: Any) -> None:
    """Add the lights of a film to a stage.

    Args:
        stage: The stage.
        at: Path of the parent prim.
        film: The film description of the run's `render.py`.
        name_of: Converts a name to one that USD allows.
    """
    gain = float(film.get("gain", 1.0))
    for name, light in film["lights"].items():
        path, strength = f"{at}/{name_of(name)}", float(light["strength"]) * gain
        # A sky has its own colour, and the case gives none.
        color = linear(np.asarray(light.get("color", (1.0, 1.0, 1.0)), float))
        kind = light["kind"]
        if kind == "sun":
            _sun(stage, path, light, color, strength)
        elif kind == "softbox":
            _softbox(stage, path, light, color, strength)
        elif kind in ("lamp", "spot"):
            _lamp(stage, path, light, color, strength)
        elif kind == "environment":
            above, horizon = color, linear(np.asarray(light["horizon"], float))
            _common(openusd().UsdLux.DomeLight.Define(stage, path), (above + horizon) / 2, strength)
        elif kind == "sky":
            low = max(abs(light["direction"][2]) / np.linalg.norm(light["direction"]), 0.15)
            _sun(stage, path, light | {"angle": 0.02}, color, CLEAR * strength / low)
            _common(openusd().UsdLux.DomeLight.Define(stage, f"{path}_dome"), color, (1 - CLEAR) * strength / pi)


def _sun(stage: Any, path: str, light: dict[str, Any], color: Any, strength: float) -> None:
    light_prim = openusd().UsdLux.DistantLight.Define(stage, path)
    _common(light_prim, color, strength)
    light_prim.CreateNormalizeAttr(True)  # its intensity is then the irradiance of a surface that faces it
    light_prim.CreateAngleAttr(degrees(light["angle"]))
    _place(light_prim, (0, 0, 0), light["direction"])


def _softbox(stage: Any, path: str, light: dict[str, Any], color: Any, strength: float) -> None:
    light_prim = openusd().UsdLux.RectLight.Define(stage, path)
    _common(light_prim, color, strength / box_irradiance(light["size"], light["distance"]))
    light_prim.CreateWidthAttr(light["size"])
    light_prim.CreateHeightAttr(light["size"])
    direction = np.asarray(light["direction"], float) / np.linalg.norm(light["direction"])
    pos = np.asarray(light["at"], float) - light["distance"] * direction
    _place(light_prim, pos, direction)


def _lamp(stage: Any, path: str, light: dict[str, Any], color: Any, strength: float) -> None:
    light_prim = openusd().UsdLux.SphereLight.Define(stage, path)
    radius = POINT if light["kind"] == "spot" else float(light["radius"])
    _common(light_prim, color, strength / (pi * radius**2))
    light_prim.CreateRadiusAttr(radius)
    direction = (0, 0, -1)
    if light["kind"] == "spot":
        shaping = openusd().UsdLux.ShapingAPI.Apply(light_prim.GetPrim())
        shaping.CreateShapingConeAngleAttr(degrees(light["angle"]) / 2)
        shaping.CreateShapingConeSoftnessAttr(float(light["blur"]))
        direction = np.subtract(light["look_at"], light["pos"])
    _place(light_prim, light["pos"], direction)


def _common(made: Any, color: Any, intensity: float) -> None:
    made.CreateColorAttr(openusd().Gf.Vec3f(*(float(x) for x in color)))
    made.CreateIntensityAttr(float(intensity))


def _place(made: Any, pos: Any, direction: Any) -> None:
    start = np.asarray(pos, float)
    turn = facing(start, start + np.asarray(direction, float))
    ops = openusd().UsdGeom.Xformable(made)
    ops.AddTranslateOp().Set(openusd().Gf.Vec3d(*start.tolist()))
    ops.AddOrientOp().Set(openusd().Gf.Quatf(*turn.tolist()))
