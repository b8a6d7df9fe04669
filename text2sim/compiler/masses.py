"""What everything weighs."""

from text2sim.compiler.build import Resolution
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes import geometry


def masses(resolution: Resolution) -> dict[str, float]:
    """Return the mass [kg] of every copy of a body, by its name; of a file's body, what the file says."""
    lowering = resolution.lowering
    densities = {entity.name: entity.rho for group in resolution.plan.bodies for entity in group.entities}
    found: dict[str, float] = {}
    volumes: dict[int, tuple[object, float]] = {}

    def volume(copy: Copy) -> float:
        # The shape is kept beside its volume, so that its id stays its own.
        if id(copy.shape) not in volumes:
            pieces = geometry.pieces(copy.shape, lowering.folder)
            volumes[id(copy.shape)] = copy.shape, sum(piece.volume() for piece in pieces)
        return volumes[id(copy.shape)][1]

    for name in resolution.loaded.case.bodies:
        for copy in resolution.placed[name]:
            tree = lowering.trees.get(copy.name)
            density = densities[copy.name]
            if getattr(copy.model, "file", None) is not None:
                found[copy.name] = lowering.mechanisms[copy.model.file, copy.model.base].mass
            elif tree is not None:
                geoms = (geom for link in tree.links() for geom in link.geoms)
                found[copy.name] = sum(geom.density * geom.piece.volume() for geom in geoms)
            elif density is not None:
                found[copy.name] = density * volume(copy)
    return found
