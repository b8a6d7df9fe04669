"""A scene to place bodies in, with shorthands for bodies and for where they start."""

from text2sim.compiler.placing.placement import place_all
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.solid import solids
from text2sim.compiler.shapes.sweep import least_distance
from text2sim.compiler.trees.link_trees import link_frames, tree_extents, tree_standing
from text2sim.spec_schema.load import load_text

HEAD = """\
text2sim: 1
name: test
scene:
  duration: 1
  statics:
    floor: {shape: {kind: plane}}
    table: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [5, 0, 0.7]}}
    tray: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [0, 5, 0.7], euler_deg: [0, 0, 90]}}
    cup: {shape: {kind: cup, radius: 0.3, height: 0.4, thickness: 0.03}, pose: {pos: [-3, 0, 0.2]}}
    pole: {shape: {kind: cylinder, radius: 0.05, height: 2}, pose: {pos: [1, 1, 1]}}
    rod: {shape: {kind: cylinder, radius: 0.05, height: 2}, pose: {pos: [1, -5, 1], euler_deg: [0, 90, 30]}}
    beam: {shape: {kind: box, size: [0.1, 2, 0.1]}, pose: {pos: [9, 9, 1]}}
    ramp: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [-9, 0, 1], euler_deg: [0, 30, 0]}}
    hill: {shape: {kind: plane}, pose: {pos: [0, 0, -9], euler_deg: [20, 0, 0]}}
    roof:
      shape:
        kind: polyhedron
        points: [[-1, -1, 0], [-1, 1, 0], [1, -1, 0], [1, 1, 0], [0, -1, 0.5], [0, 1, 0.5]]
      pose: {pos: [0, -9, 1], euler_deg: [0, 0, 90]}
    open_box:
      shape:
        kind: compound
        parts:
          ground: {shape: {kind: box, size: [1, 1, 0.02]}}
          left: {shape: {kind: box, size: [0.02, 1, 0.3]}, pose: {pos: [-0.49, 0, 0.15]}}
          right: {shape: {kind: box, size: [0.02, 1, 0.3]}, pose: {pos: [0.49, 0, 0.15]}}
          front: {shape: {kind: box, size: [1, 0.02, 0.3]}, pose: {pos: [0, -0.49, 0.15]}}
          back: {shape: {kind: box, size: [1, 0.02, 0.3]}, pose: {pos: [0, 0.49, 0.15]}}
      pose: {pos: [-6, 0, 1]}
bodies:
"""
FIRST_LINE = HEAD.count("\n") + 1
BALL = "kind: rigid, shape: {kind: sphere, radius: 0.1}"
CUBE = "kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}"
RING = "kind: rigid, shape: {kind: torus, radius: 0.1, bar_radius: 0.02}"


def start(*bodies):
    loaded = load_text(HEAD + "".join(f"  {body}\n" for body in bodies))
    return place_all(loaded, tree_extents, tree_standing, link_frames)


def placed(*bodies):
    copies, problems = start(*bodies)
    assert problems == []
    return copies


def pos_of(*bodies):
    """Where the last of some bodies starts."""
    return list(placed(*bodies).values())[-1][0].pos


def apart(copies, one, other):
    a, b = copies[one][0], copies[other][0]
    mine, theirs = (solids(pieces(copy.shape, None), copy.pos, copy.quat) for copy in (a, b))
    return least_distance(mine, theirs)
