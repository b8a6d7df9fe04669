"""Checks of a recipe against its cases, located in the recipe."""

from pathlib import Path

import pytest

from text2sim.dataset.recipe_fit import read_recipe
from text2sim.spec_schema.errors import SpecError

CASE = """\
text2sim: 2
name: drop
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    material: {density: 500}
    pose: {pos: [0, 0, 1]}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {lands: {measure: height, at: end, below: 0.2}}
render: {cameras: {main: {kind: still, from: [2, 2, 1], look_at: [0, 0, 0.5]}}}
variants: {heavy: {bodies: {ball: {material: {density: 5000}}}}}
sweeps: {densities: {grid: {bodies.ball.material.density: [100, 200]}}}
"""


def read(folder: Path, body: str, cases: str = "[drop]") -> list[str]:
    (folder / "drop").mkdir()
    (folder / "empty").mkdir()
    (folder / "drop" / "case.yaml").write_text(CASE)
    text = f"text2sim_dataset: 1\nname: x\nsources:\n  a:\n    cases: {cases}\n{body}"
    (folder / "r.yaml").write_text(text)
    return [str(warning).removeprefix(f"{folder}/") for warning in read_recipe(folder / "r.yaml")[1]]


def test_a_recipe_that_fits_is_read(tmp_path: Path) -> None:
    assert not read(
        tmp_path,
        "    variants: [heavy]\n    sweep: densities\n    holds: [lands]\n    films: 2\n"
        "    physics: {bodies.ball.material.density: {times: [1, 2]}, 'bodies.ball.pose.pos[2]': {uniform: [-1, 2]},\n"
        "      actions.events.down: {choice: [{kind: threshold, measure: height, below: 0.2}]}}\n"
        "    counterfactuals: {soft: {/bodies/ball/material/friction: {choice: [0.1]}}}\n"
        "    looks: {bodies.ball.look.color: {choice: [red]}}\n    lights: {render.exposure: {uniform: [-0.5, 0.5]}}\n"
        "    cameras: {render.shots: {choice: [{whole: {camera: main}}]}}\n",
    )


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("    variants: [haevy]\n", "r.yaml:6:16: error: "),
        ("    sweep: density\n", "r.yaml:6:12: error: "),
        ("    holds: [landed]\n", "r.yaml:6:13: error: "),
        ("    holds: [landed]\n", "has no expectation `landed`; there are lands; did you mean `lands`?"),
        ("    fails: [nothing]\n", "r.yaml:6:13: error: "),
        ("    holds: all\n    fails: [lands]\n", "r.yaml:7:13: error: `lands` cannot both hold and fail"),
        ("    physics: {bodies.bal.material.density: {uniform: [1, 2]}}\n", "r.yaml:6:15: error: there is no `bal`"),
        ("    physics: {params.a: {times: [1, 2]}, bodies.ball.material.densty: {uniform: [1, 2]}}\n", "did you mean `density`?"),
        ("    physics: {params.a: {times: [1, 2]}, bodies.ball.material.densty: {uniform: [1, 2]}}\n", "`times` or `plus`"),
        ("    physics: {bodies.ball.kind: {plus: [1, 2]}}\n", "`times` and `plus` need a number"),
        ("    counterfactuals: {soft: {bodies.ball.material.frictoin: {choice: [0]}}}\n", "r.yaml:6:30: error: "),
        ("    films: 2\n    cameras: {render.cameras.man.fov_deg: {uniform: [30, 40]}}\n", "r.yaml:7:15: error: "),
        ("    films: 2\n    lights: {render.lights.moon.strength: {times: [1, 2]}}\n", "r.yaml:7:43: error: "),
        ("    refuse: [overlp]\n", "r.yaml:6:14: error: there is no rule `overlp`"),
        ("    refuse: [overlp]\n", "did you mean `overlap`?"),
        ("    split: train\n  b: {cases: [drop], split: test}\n", "r.yaml:4:3: error: the source b shares a case"),
        ("benchmarks: [nowhere]\n", "r.yaml:6:14: error: there is no file or folder `nowhere`"),
        ("benchmarks: [empty]\n", "r.yaml:6:14: error: there is no case in `empty`"),
        ("judged: [nowhere]\n", "r.yaml:6:10: error: there is no file or folder `nowhere`"),
    ],
)  # fmt: skip
def test_missing_parts_of_cases_are_located_in_the_recipe(tmp_path: Path, body: str, said: str) -> None:
    with pytest.raises(SpecError) as caught:
        read(tmp_path, body)
    assert said in str(caught.value)


def test_looks_that_no_film_shows_are_warned_of(tmp_path: Path) -> None:
    body = (
        "    looks: {bodies.ball.look.color: {choice: [red]}}\n    lights: {render.exposure: {uniform: [-0.5, 0.5]}}\n"
    )
    message = "is not drawn: the first film of a simulation is as in the case; use `films: 2` [unused]"
    assert read(tmp_path, body) == [
        f"r.yaml:6:5: warning: `looks` {message}",
        f"r.yaml:7:5: warning: `lights` {message}",
    ]


@pytest.mark.parametrize("cases", ["[drip]", "[empty]"])
def test_a_missing_case_is_reported(tmp_path: Path, cases: str) -> None:
    with pytest.raises(SpecError, match=r"r\.yaml:5:13: error: there is no "):
        read(tmp_path, "", cases)
