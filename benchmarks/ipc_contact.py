"""Bodies under contact model ipc against equations. Needs CUDA, and takes five minutes.

    python -m benchmarks.ipc_contact

A block slides down a slope, and another one should lie still: a = g (sin b - mu cos b). Strips of cloth hang over an
edge: for small angles, the tip is q L^4 / (8 D) below it (Euler and Bernoulli, q: weight per area, D: rigidity). Strips
that two shelves hold sag by d: d^3 = 3 q L^4 / (64 E t) (a shallow parabola of strain 8 d^2 / (3 L^2)). A cube of
rubber rests: its middle lies where contact begins.
"""

import tempfile
from math import cos, radians, sin
from pathlib import Path

from text2sim.harness.run import run_case
from text2sim.spec_schema.load import load_text

G, SLOPE, WEIGHT, THICK = 9.81, 20.0, 0.3 * 9.81, 1e-3
OVERHANG, SPAN = 0.15, 0.4
RIGIDITIES, MODULI = (0.02, 0.05, 0.1), (3e4, 1e5, 1e6)
SIDE, YOUNG = 0.1, 1e6

HEAD = """\
text2sim: 2
name: {name}
scene:
  duration: 1.0
  dt: 0.01
  contact: {{model: ipc}}
  statics:
    floor: {{shape: {{kind: plane, size: 8}}}}
"""
BLOCK = """\
  block_{k}:
    kind: rigid
    shape: {{kind: box, size: [0.1, 0.1, 0.06]}}
    material: {{friction: {mu}, density: 600}}
    pose: {{pos: [{x}, {y}, {z}], euler_deg: [0, 20, 0]}}
"""
STRIP = """\
  strip_{k}:
    kind: cloth
    solver: ipc
    cell: {cell}
    shape: {{kind: sheet, size: [{length}, 0.12]}}
    material: {{area_density: 0.3, thickness: 0.001, friction: 1.0, {more}}}
    pose: {{pos: [0, {y}, 1.0025]}}
"""
LOAD = """\
  load_{k}:
    kind: rigid
    shape: {{kind: box, size: [{length}, 0.14, 0.05]}}
    material: {{density: 6000, friction: 1}}
    pose: {{pos: [{x}, {y}, 1.0305]}}
"""
SHELF = """\
    {name}:
      shape: {{kind: box, size: [0.3, 1.6, 0.05]}}
      material: {{friction: 1}}
      pose: {{pos: [{x}, 0, 0.975]}}
"""
CUBE = """\
  cube:
    kind: soft
    solver: fem
    cell: 0.02
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {youngs_modulus: 1.0e+6, density: 1000}
    pose: {pos: [0, 2, 0.053]}
"""


def measured(name: str, statics: str, bodies: str, measures: dict[str, str]) -> dict[str, float]:
    """Run a scene, and return the value of each measure at each time, by `measure@time`."""
    text = HEAD.format(name=name) + statics + "bodies:\n" + bodies + "actions:\n  measures:\n"
    text += "".join(f"    {key}: {value}\n" for key, value in measures.items()) + "  expect:\n"
    times = {f"{key}@{time}": (key, time) for key in measures for time in (0.3, 0.9)}
    rows = enumerate(times.values())
    text += "".join(f"    e{k}: {{measure: {key}, at: {time}, below: 99}}\n" for k, (key, time) in rows)
    with tempfile.TemporaryDirectory() as folder:
        found = run_case(load_text(text), runs=Path(folder), film=False).expectations
        return {key: found[f"e{k}"]["value"] for k, key in enumerate(times)}


def slope() -> None:
    """Print the acceleration of a block that slides, the speed of one that should not, and where a cube rests."""
    b = radians(SLOPE)
    up, out = -0.48, 0.0812
    x, z = up * cos(b) + out * sin(b), 0.8 - up * sin(b) + out * cos(b)
    bodies = "".join(
        BLOCK.format(k=k, mu=mu, x=f"{x:.5f}", y=y, z=f"{z:.5f}") for k, (mu, y) in enumerate(((0.1, 0.2), (0.6, -0.2)))
    )
    ramp = "    ramp: {shape: {kind: box, size: [2, 0.8, 0.1]}, material: {friction: 0.4}, "
    ramp += "pose: {pos: [0, 0, 0.8], euler_deg: [0, 20, 0]}}\n"
    measures = {f"v{k}": f"{{kind: speed, of: block_{k}}}" for k in range(2)}
    measures["height"] = "{kind: position, of: cube, axis: z}"
    found = measured("slope", ramp, bodies + CUBE, measures)
    law = G * (sin(b) - (0.1 * 0.4) ** 0.5 * cos(b))
    print(f"sliding block: {(found['v0@0.9'] - found['v0@0.3']) / 0.6:.2f} m/s2, by the law {law:.2f}")
    print(f"block at rest: creeps at {1e3 * found['v1@0.9']:.1f} mm/s")
    print(f"cube at rest: {1e3 * (found['height@0.9'] - SIDE / 2):.1f} mm above where it would touch", flush=True)


def strips(name: str, shelves: dict[str, float], loads: dict[str, tuple[float, float]], rows: list[str]) -> list[float]:
    """Return how far each strip hangs down [m].

    Args:
        name: Of the scene.
        shelves: Position along x [m] by name.
        loads: Position along x and length [m] of what holds a strip down, by name.
        rows: More of the material of each strip.
    """
    length, cell = (0.3, 0.015) if len(shelves) == 1 else (0.8, 0.02)
    bodies = ""
    for k, more in enumerate(rows):
        y = f"{-0.4 + 0.4 * k:.2f}"
        bodies += STRIP.format(k=k, length=length, cell=cell, more=more, y=y)
        for end, (x, size) in loads.items():
            bodies += LOAD.format(k=f"{end}_{k}", length=size, x=x, y=y)
    statics = "".join(SHELF.format(name=end, x=x) for end, x in shelves.items())
    extents = {f"h{k}": f"{{kind: extent, of: strip_{k}, axis: z, stat: range}}" for k in range(len(rows))}
    found = measured(name, statics, bodies, extents)
    return [found[f"h{k}@0.9"] for k in range(len(rows))]


if __name__ == "__main__":
    slope()
    hanging = strips("hang", {"shelf": -0.15}, {"load": (-0.07, 0.14)}, [f"rigidity: {d}" for d in RIGIDITIES])
    for d, found in zip(RIGIDITIES, hanging, strict=True):
        print(
            f"strip, D = {d} N m: tip {1e3 * found:.1f} mm down, by the law {1e3 * WEIGHT * OVERHANG**4 / (8 * d):.1f}"
        )
    ends = {"left": (-0.3, 0.2), "right": (0.3, 0.2)}
    sagging = strips("sag", {"left": -0.35, "right": 0.35}, ends, [f"youngs_modulus: {e:.0f}" for e in MODULI])
    for e, found in zip(MODULI, sagging, strict=True):
        law = (3 * WEIGHT * SPAN**4 / (64 * e * THICK)) ** (1 / 3)
        print(f"strip, E = {e:.0e} Pa: sags {1e3 * found:.1f} mm, by the law {1e3 * law:.1f}")
