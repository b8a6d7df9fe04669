"""Slim bodies fall over on mpm bodies where their foot has few nodes of the grid: the bound of the rule narrow-foot."""

from collections.abc import Callable
from typing import Any

from text2sim.lint.soft.feet import MIN_FOOT_CELLS

SCENE = """
scene: {duration: 0.5, dt: 0.002, mpm: {cell: 0.02}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  foam:
    kind: soft
    shape: {kind: box, size: [0.42, 0.3, 0.1]}
    material: {density: 100, youngs_modulus: 20000, poisson_ratio: 0.2}
    place: {on: floor}
"""


def test_feet_of_few_nodes_tip_and_wide_ones_stand(simulate: Callable[..., Any]) -> None:
    """Three cylinders two cells wide and three of `MIN_FOOT_CELLS` cells, at three places between the nodes."""
    bodies, measures = "", ""
    for name, cells, y in (("narrow", 2.0, -0.07), ("wide", MIN_FOOT_CELLS, 0.07)):
        for k, x in enumerate((-0.14, 0.0067, 0.1533)):
            bodies += (
                f"  {name}_{k}: {{kind: rigid, shape: {{kind: cylinder, radius: {cells * 0.01:g}, height: 0.12}}, "
                f"material: {{density: 300}}, pose: {{pos: [{x}, {y}, 0.172]}}}}\n"
            )
            measures += f"    {name}_{k}: {{kind: tilt, of: {name}_{k}, axis: z}}\n"
    trial = simulate(f"{SCENE}{bodies}actions:\n  measures:\n{measures}")
    tilt = {name: max(trial.measure(f"{name}_{k}")[-1] for k in range(3)) for name in ("narrow", "wide")}
    assert tilt["narrow"] > 20
    assert tilt["wide"] < 2
