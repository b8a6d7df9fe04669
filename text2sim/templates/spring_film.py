"""Draws springs in the preview, with nodes of their own in the engine's rasterizer."""

from coils import Coils
from genesis.ext import pyrender

FINISH = {
    "coil": {"metallicFactor": 0.5, "roughnessFactor": 0.4},
    "cord": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
}


class SpringFilm:
    """Draws the springs of a film.

    Args:
        scene: Built scene.
        states: The recorded states.
        looks: Form, radius and colour of the springs of each control.
    """

    def __init__(self, scene, states, looks: dict[str, dict]):
        self._context, self._looks, self._nodes = scene.visualizer.context, looks, []
        self._coils = Coils(states, looks)

    def show(self, t: float) -> None:
        """Updates every spring to a time [s]; call before rendering a picture."""
        self.clear()
        for strand in self._coils.at(t):
            material = pyrender.MetallicRoughnessMaterial(
                baseColorFactor=(*self._looks[strand.control]["color"], 1.0), **FINISH[strand.form]
            )
            primitive = pyrender.Primitive(
                positions=strand.vertices, normals=strand.normals, indices=strand.faces, material=material
            )
            self._nodes.append(self._context.add_node(pyrender.Mesh([primitive])))

    def clear(self) -> None:
        """Removes the springs from the scene."""
        for node in self._nodes:
            self._context.remove_node(node)
        self._nodes = []
