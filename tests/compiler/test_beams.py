"""Beams: their springs bend and swing as the equations of a beam say, before the engine integrates them."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from text2sim.compiler.build import resolve_case
from text2sim.compiler.emit import emit
from text2sim.compiler.trees.beams import beam_frequency, beam_tree, first_frequency, shaking_frequency
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.soft_bodies import Beam

SIZE, MODULUS, DENSITY = (0.3, 0.03, 0.005), 1e9, 1100.0
INERTIA = 0.03 * 0.005**3 / 12
"""Second moment of area [m4]."""


def beam(**more) -> Beam:
    data = {"kind": "beam", "size": SIZE, "youngs_modulus": MODULUS, "material": {"density": DENSITY}}
    return Beam.model_validate(data | more)


def matrices(made: Beam) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass matrix, stiffness and distance [m] from each hinge to the tip of a clamped beam, from what is emitted."""
    links = beam_tree(made, None).links()
    at = np.cumsum([link.pos[0] for link in links])
    mass = np.zeros((len(links), len(links)))
    for k, link in enumerate(links):
        own = link.inertial
        arm = np.where(np.arange(len(links)) <= k, at[k] + own.center[0] - at, 0.0)
        turns = np.arange(len(links)) <= k
        mass += own.mass * np.outer(arm, arm) + own.inertia[1] * np.outer(turns, turns)
    return mass, np.array([link.joint.spring for link in links]), made.size[0] - at


@pytest.mark.parametrize("segments", [2, 4, 10, 30])
def test_a_force_at_the_tip_bends_it_by_f_l3_over_3_e_i(segments: int) -> None:
    """Each hinge turns by the moment F (L - x) over its spring; exact for any number of links."""
    _, spring, reach = matrices(beam(segments=segments))
    assert (reach**2 / spring).sum() == pytest.approx(0.3**3 / (3 * MODULUS * INERTIA), rel=1e-9)


@pytest.mark.parametrize("segments", [4, 10, 30])
def test_it_swings_with_the_first_frequency_of_a_clamped_beam(segments: int) -> None:
    """0.21 / N^2 too slowly; the damping ratio of the first mode is the author's, as far as the frequencies agree.

    The rotary inertia of its section, which the equation neglects, takes off 2.3 I / (A L^2) = 5e-5.
    """
    made = beam(segments=segments, damping_ratio=0.05)
    mass, spring, _ = matrices(made)
    squares, modes = np.linalg.eig(np.linalg.solve(mass, np.diag(spring)))
    first = squares.real.argmin()
    theory = 1.875104069**2 * np.sqrt(MODULUS * INERTIA / (DENSITY * 0.03 * 0.005 * 0.3**4))
    assert first_frequency(made) == pytest.approx(theory, rel=1e-9)
    found = np.sqrt(squares.real[first])
    assert found / theory - 1 == pytest.approx(-0.21 / segments**2, rel=0.05, abs=6e-5)
    mode = modes[:, first].real
    damping = np.array([link.joint.damping for link in beam_tree(made, None).links()])
    ratio = (damping * mode**2).sum() / (2 * found * mode @ mass @ mode)
    assert ratio == pytest.approx(0.05, rel=0.3 / segments**2)


@pytest.mark.parametrize("segments", [2, 5, 20])
def test_no_mode_is_faster_than_the_one_that_the_substeps_follow(segments: int) -> None:
    made = beam(segments=segments, damping_ratio=0)
    mass, spring, _ = matrices(made)
    fastest = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, np.diag(spring))).real.max())
    assert 0.6 * shaking_frequency(made) < fastest < shaking_frequency(made) == beam_frequency(made)


def test_damping_makes_substeps_independent_of_the_number_of_links() -> None:
    """The fastest mode wn has the damping ratio zeta wn / w1: w1 / (2 zeta) is left of wn. Much damping leaves 4 w1."""
    first = first_frequency(beam())
    for segments in (10, 40):
        assert shaking_frequency(beam(segments=segments)) == pytest.approx(first / 0.04, rel=0.05)
    assert beam_frequency(beam(damping_ratio=0.5)) == pytest.approx(4 * first)


def test_it_weighs_what_a_box_does_and_the_clamp_touches_nothing() -> None:
    links = beam_tree(beam(), None).links()
    assert sum(link.inertial.mass for link in links) == pytest.approx(DENSITY * 0.3 * 0.03 * 0.005)
    assert sum(geom.density * geom.piece.volume() for link in links for geom in link.geoms) == pytest.approx(0.0495)
    assert [link.name for link in links] == [f"link_{k}" for k in range(10)]
    (touched,) = (geom.piece for geom in links[0].geoms if geom.touches)
    assert touched.pos[0] - touched.size[0] / 2 == pytest.approx(0.0025)
    assert links[1].geoms[0].piece.size[0] == pytest.approx(0.03 + 2 * 0.14 * 0.005), "no gap is open where it bends"
    assert {joint.axis for _, joint in beam_tree(beam(), None).joints()} == {(0.0, 1.0, 0.0)}
    assert beam_tree(beam(anchored=False), None).links()[0].joint.kind == "free"


def test_a_short_thick_beam_has_fewer_links() -> None:
    assert beam(size=(0.1, 0.03, 0.03)).segments == 3
    with pytest.raises(ValidationError, match="use fewer segments"):
        beam(size=(0.1, 0.03, 0.03), segments=8)
    with pytest.raises(ValidationError, match="the thickness must be the least"):
        beam(size=(0.3, 0.005, 0.03))


CASE = """
text2sim: 2
name: probe
scene: {{duration: 1, dt: 0.005}}
bodies:
  board: {{kind: beam, size: [0.3, 0.03, 0.005], youngs_modulus: 1e9, anchored: false, pose: {{pos: [0, 0, 1]}}}}
  hub: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [-0.1, 0, 1]}}}}
  other: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [-0.3, 0, 1]}}}}
actions:
  controls:
    first: {{kind: attach, body: other, to: hub}}
    second: {{kind: attach, body: board.link_0, to: hub{more}}}
"""


@pytest.mark.parametrize(("more", "stiff"), [("", True), (", pivot: [0, 0, 0]", False)])
def test_only_a_weld_that_holds_a_beam_is_stiff(tmp_path: Path, more: str, stiff: bool) -> None:
    (tmp_path / "case.yaml").write_text(CASE.format(more=more))
    plan = resolve_case(load_case(tmp_path)).plan
    assert [weld.stiff for weld in plan.welds] == [False, stiff]
    program = emit(plan)
    assert (b"SLACK" in program["actions.py"]) == stiff
    assert program["bodies.py"].count(b"smooth=False") == 1, "with smoothed edges its links look like scales"
