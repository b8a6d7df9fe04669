"""Prefabs: what a use becomes."""

from pathlib import Path

import pytest
from stick_prefabs import HEAD, STICK

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.reuse.expanded import expanded_text
from text2sim.spec_schema.reuse.library import VARIABLE
from text2sim.spec_schema.reuse.overlay import CaseOverlay

ENDLESS = 60.0
"""CPU time [s] that only work which doubles at every step can take; all of it is done in a fraction of a second."""


def test_defaults_stand_for_what_is_not_given(load_uses):
    loaded = load_uses("  s: {use: stick}\n")
    assert loaded.raw["bodies"]["s"] == {
        "kind": "rigid",
        "shape": {"kind": "box", "size": [0.05, 0.05, 0.5]},
        "material": {"density": 700},
        "pose": {"pos": [0, 0, 0]},
        "look": {"color": "red", "finish": "wood"},
    }


def test_arguments_go_into_expressions_and_stay_what_they_are(load_uses):
    loaded = load_uses("  s: {use: stick, with: {length: '${d + 0.1}', at: [1, '${speed}', 2], what: metal}}\n")
    body = loaded.raw["bodies"]["s"]
    assert body["shape"]["size"] == ["${(d + 0.1) / 10}", "${(d + 0.1) / 10}", "${d + 0.1}"]
    assert body["pose"] == {"pos": [1, "${speed}", 2]}
    assert body["material"] == {"density": 7800}
    assert loaded.case.bodies["s"].shape.size == pytest.approx((0.03, 0.03, 0.3))


def test_whatever_stands_beside_a_use_is_laid_over_the_body(load_uses):
    loaded = load_uses(
        "  s: {use: stick, pose: null, place: {on: floor}, look: {color: blue}, shape: {kind: sphere, radius: 1}}\n"
    )
    body = loaded.raw["bodies"]["s"]
    assert body["look"] == {"color": "blue", "finish": "wood"}
    assert body["shape"] == {"kind": "sphere", "radius": 1}
    assert body["place"] == {"on": "floor"}
    assert "pose" not in body


def test_arguments_may_differ_from_copy_to_copy(load_uses):
    use = "{use: stick, with: {length: '${0.2 + 0.1 * i}'}, repeat: {kind: line, count: %d, step: [1, 0, 0]}}"
    loaded = load_uses(f"  s: {use % 3}\n")
    assert [loaded.body_copy("s", {"i": i, "n": 3}).shape.size[2] for i in range(3)] == pytest.approx([0.2, 0.3, 0.4])
    loaded = load_uses(f"  s: {use % 30}\n")
    with pytest.raises(SpecError) as caught:
        loaded.body_copy("s", {"i": 29, "n": 30})
    (problem,) = caught.value.problems
    assert problem.path == "/bodies/s/with/length"
    assert problem.message == "copy 29: needs a length [m] from 0.1 to 2 (got the number 3.1)"


def test_a_prefab_that_counts_copies_is_one_copy_by_itself(load_uses, write_prefabs):
    write_prefabs(
        striped=STICK.replace("stick", "striped").replace(
            "${hue if plain else 'black'}", "${'red' if i % 2 == 0 else 'white'}"
        )
    )
    assert load_uses("  s: {use: striped}\n").raw["bodies"]["s"]["look"]["color"] == "red"
    loaded = load_uses("  s: {use: striped, repeat: {kind: stack, count: 2}}\n")
    assert loaded.body_copy("s", {"i": 1, "n": 2}).look.color == "white"


def test_several_bodies_go_by_the_names_of_their_parts(load_uses):
    loaded = load_uses(
        "  left: {use: gate, with: {width: 2}, bar: {look: {color: gold}}}\n  right: {use: gate, with: {width: 1}}\n"
    )
    assert list(loaded.raw["bodies"]) == ["other", "left_post", "left_bar", "right_post", "right_bar"]
    assert loaded.raw["bodies"]["left_bar"]["look"] == {"color": "gold"}
    assert loaded.raw["bodies"]["left_bar"]["place"] == {"on": "left_post", "facing": "left_post[*]"}
    assert loaded.raw["bodies"]["left_post"]["shape"]["size"] == [0.1, 0.1, 1]
    assert loaded.raw["bodies"]["left_post"]["mount"] == {"kind": "fixed"}
    assert check_references(loaded) == []


def test_null_takes_a_part_away(load_uses):
    loaded = load_uses("  left: {use: gate, with: {width: 2}, bar: null}\n")
    assert list(loaded.raw["bodies"]) == ["other", "left_post"]
    assert check_references(loaded) == []


def test_a_static_takes_the_body_without_its_mass(tmp_path: Path, write_prefabs):
    text = HEAD.replace("floor: {", "pole: {use: stick, with: {length: 2}, look: {color: blue}}, floor: {")
    text += "bodies: {b: {kind: ragdoll, height: 1, place: {on: pole}}}\n"
    loaded = load_text(text, tmp_path / "case.yaml")
    assert loaded.raw["scene"]["statics"]["pole"] == {
        "shape": {"kind": "box", "size": [0.2, 0.2, 2]},
        "material": {},
        "pose": {"pos": [0, 0, 0]},
        "look": {"color": "blue", "finish": "wood"},
    }
    assert check_references(loaded) == []


def test_a_prefab_is_found_in_the_case_then_its_folder_then_elsewhere(load_uses, write_prefabs, tmp_path, monkeypatch):
    own = "prefabs: {stick: {body: {kind: ragdoll, height: 2}}}\n"
    assert load_uses("  s: {use: stick}\n", own).raw["bodies"]["s"] == {"kind": "ragdoll", "height": 2}
    more = tmp_path / "more"
    more.mkdir()
    for name in ("stick", "thing", "table"):
        (more / f"{name}.yaml").write_text(f"text2sim: 2\nprefab: {name}\nbody: {{kind: ragdoll, height: 3}}\n")
    monkeypatch.setenv(VARIABLE, str(more))
    bodies = load_uses("  s: {use: stick}\n  t: {use: thing}\n  u: {use: table}\n").raw["bodies"]
    assert [bodies[name].get("height") for name in "stu"] == [None, 3, 3]
    monkeypatch.delenv(VARIABLE)
    assert load_uses("  u: {use: table}\n").raw["bodies"]["u"]["kind"] == "rigid"


def test_variants_and_values_reach_into_a_use(load_uses):
    bodies = "  s: {use: stick, with: {length: 1}}\n  g: {use: gate, with: {width: 1}}\n"
    top = "variants: {long: {bodies: {s: {with: {length: 2}, look: {color: blue}}}}, round: {bodies: {s: {kind: ragdoll, height: 1}}}}\n"
    body = load_uses(
        bodies, top, overlay=CaseOverlay(("long",), ("bodies.s.with.hue=pink", "bodies.g.bar.look.color=gold"))
    ).raw["bodies"]
    assert body["s"]["shape"]["size"][2] == 2
    assert body["s"]["look"]["color"] == "blue"
    assert body["g_bar"]["look"]["color"] == "gold"
    assert load_uses(bodies, top, overlay=CaseOverlay(("round",))).raw["bodies"]["s"] == {
        "kind": "ragdoll",
        "height": 1,
    }


def test_an_expanded_case_loads_to_the_same(load_uses, tmp_path):
    loaded = load_uses(
        "  s: {use: stick, with: {length: '${0.2 + d * i}', hue: '${\"red\" if i == 0 else \"blue\"}'}, repeat: {kind: stack, count: 2}}\n"
        "  g: {use: gate, with: {width: '${d}'}}\n"
        "  long: {use: stick, with: {length: '${"
        + "1 * " * 60
        + "d}', at: ['${"
        + " + ".join(["speed - speed"] * 30)
        + "}', 0, 0]}}\n"
    )
    again = load_text(expanded_text(loaded), tmp_path / "elsewhere" / "case.yaml")
    assert again.data == loaded.data
    assert again.case == loaded.case
    for index in (0, 1):
        assert again.body_copy("s", {"i": index, "n": 2}) == loaded.body_copy("s", {"i": index, "n": 2})


def test_a_plain_case_does_without_the_code_for_prefabs():
    import subprocess
    import sys

    code = (
        "import sys; from pathlib import Path; from text2sim.spec_schema.load import load_case;"
        "load_case(sys.argv[1]);"
        "found = {f'text2sim.spec_schema.{m}' for m in ('reuse.layers', 'reuse.prefabs', 'reuse.library', 'reuse.sweeps', 'vocabulary.reach')} & set(sys.modules);"
        "assert not found, found"
    )
    case = Path(__file__).resolve().parents[2] / "cases" / "brick_wall"
    subprocess.run([sys.executable, "-c", code, case], check=True, timeout=60)
