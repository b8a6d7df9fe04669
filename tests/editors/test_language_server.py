"""What editors make of the published schema: the real yaml-language-server, over its own protocol."""

from pathlib import Path

import pytest
from language_server import Server, elapsed

from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.published.language_reference import section_kinds

ROOT = Path(__file__).resolve().parents[2]
MODELINE = "# yaml-language-server: $schema=../../spec_schema/case.schema.json\n"
HEAD = "text2sim: 2\nname: probe\nscene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}\n"
BALL = "bodies:\n  ball:\n    kind: rigid\n    shape: {kind: sphere, radius: 0.1}\n"
WHOLE = MODELINE + HEAD + BALL
CASES = sorted((ROOT / "cases").glob("*/case.yaml"))
BODIES = 2_000
LONGEST = 20.0
"""Time [s] for a case of so many bodies; a second on a quiet machine."""


def squiggles(server: Server, path: Path, text: str) -> list[tuple[str, str]]:
    """What is underlined, and why."""
    found, lines = [], text.splitlines()
    for row in server.open(path, text):
        start, end = row["range"]["start"], row["range"]["end"]
        last = end["character"] if end["line"] == start["line"] else None
        found.append((lines[start["line"]][start["character"] : last], row["message"]))
    return found


def test_a_valid_case_has_no_squiggle(server, case):
    assert squiggles(server, case, WHOLE) == []


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.parent.name)
def test_no_case_of_ours_has_a_squiggle(server, path):
    text = path.read_text("utf-8")
    assert "yaml-language-server: $schema=" in text.splitlines()[0]
    assert squiggles(server, path, text) == []


@pytest.mark.parametrize(
    "addition",
    [
        '    material: {density: "${500 * 2}"}\n',
        '    pose: {pos: "${[0, 0, 1]}"}\n',
        '    pose: {pos: [0, 0, "${r + 1}"]}\n',
        '    look: {color: "${[0.1, 0.2, 0.3]}"}\n',
    ],
)
def test_an_expression_may_stand_for_a_value(server, case, addition):
    assert squiggles(server, case, WHOLE + addition) == []


def test_a_vector_of_the_wrong_length_is_underlined(server, case):
    ((where, why),) = squiggles(server, case, WHOLE + "    pose: {pos: [0, 0]}\n")
    assert where == "[0, 0]"
    assert "Expected 3" in why


def test_an_unknown_key_is_underlined(server, case):
    assert squiggles(server, case, WHOLE + "    colour: red\n") == [("colour", "Property colour is not allowed.")]


@pytest.mark.parametrize(
    ("old", "new", "where", "why"),
    [
        ("kind: sphere", "kind: shpere", "shpere", '"sphere"'),
        ("kind: rigid", "kind: rigidd", "rigidd", '"rigid", "driven", "articulated"'),
        ("radius: 0.1", "radius: -0.1", "-0.1", "minimum of 0"),
        ("radius: 0.1", "radius: big", "big", "pattern"),
        (", radius: 0.1", "", "shape", 'Missing property "radius"'),
        ("duration: 1", "duration: yes", "yes", "pattern"),
    ],
)
def test_what_is_wrong_is_underlined_where_it_is(server, case, old, new, where, why):
    """One squiggle, about the kind that is meant: never one for each kind that might have been."""
    ((underlined, message),) = squiggles(server, case, WHOLE.replace(old, new))
    assert underlined.startswith(where)
    assert why in message


def test_a_body_offers_its_kind_or_a_prefab(server, case):
    assert {"kind", "use"} <= server.complete(case, MODELINE + HEAD + "bodies:\n  ball:\n    |\n").keys()


def test_a_body_of_a_kind_offers_the_keys_of_that_kind(server, case):
    offered = server.complete(case, MODELINE + HEAD + "bodies:\n  ball:\n    kind: rigid\n    |\n").keys()
    assert {"shape", "material", "mount", "pose", "place", "repeat", "look"} <= offered
    assert not {"link_length", "cells", "motion", "links"} & offered, "keys of other kinds"


def test_kinds_are_offered_with_what_they_mean(server, case):
    offered = server.complete(case, MODELINE + HEAD + "bodies:\n  ball:\n    kind: |\n")
    assert set(section_kinds(Body)) == offered.keys()
    assert "prescribed motion" in str(offered["driven"]["documentation"])


@pytest.mark.parametrize(
    ("text", "some"),
    [
        (BALL.replace("{kind: sphere, radius: 0.1}", "\n      kind: |"), {"box", "sphere", "torus", "compound"}),
        (BALL + "    mount:\n      kind: |\n", {"fixed", "hinge", "slider", "ball"}),
        (BALL + "    repeat:\n      kind: |\n", {"line", "grid", "running_bond"}),
        (BALL + "actions:\n  controls:\n    push:\n      kind: |\n", {"impulse", "force", "drive", "attach"}),
        (BALL + "actions:\n  measures:\n    height:\n      kind: |\n", {"position", "speed", "energy"}),
        (BALL + "render:\n  cameras:\n    main:\n      kind: |\n", {"still", "orbit", "follow", "dolly"}),
    ],
    ids=["shape", "mount", "repeat", "control", "measure", "camera"],
)
def test_kinds_are_offered_everywhere(server, case, text, some):
    assert some <= server.complete(case, MODELINE + HEAD + text).keys()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (WHOLE.replace("radius", "rad|ius"), r"Radius \[m\]"),
        (WHOLE + "    material: {den|sity: 100}\n", r"Density \[kg/m3\]"),
        (WHOLE.replace("duration", "dura|tion"), r"\[s\]"),
        (WHOLE.replace("kind: rigid", "kind: ri|gid"), "One rigid body"),
    ],
    ids=["radius", "density", "duration", "kind"],
)
def test_hovering_tells_meaning_and_unit(server, case, text, words):
    assert words in server.hover(case, text)


def test_the_schema_can_be_named_in_the_settings_instead(command, tmp_path):
    schema = (ROOT / "text2sim/spec_schema/case.schema.json").as_uri()
    server = Server(command, {"schemas": {schema: ["**/case.yaml"]}})
    try:
        path = tmp_path / "case.yaml"
        assert squiggles(server, path, HEAD + BALL) == []
        assert [where for where, _ in squiggles(server, path, HEAD + BALL + "    colour: red\n")] == ["colour"]
    finally:
        server.close()


def test_a_large_case_is_validated_while_one_writes(server, case):
    body = "  b{0}:\n    kind: rigid\n    shape: {{kind: box, size: [0.1, 0.1, 0.1]}}\n    pose: {{pos: [{0}, 0, 0]}}\n"
    text = MODELINE + HEAD + "bodies:\n" + "".join(body.format(i) for i in range(BODIES))
    seconds, found = elapsed(lambda: server.open(case, text))
    assert found == []
    assert seconds < LONGEST


PREFABS = sorted((ROOT / "text2sim/prefabs").glob("*.yaml"))


@pytest.mark.parametrize("path", PREFABS, ids=lambda path: path.stem)
def test_no_prefab_of_ours_has_a_squiggle(server, path):
    """The same schema serves files with prefabs."""
    modeline = "# yaml-language-server: $schema=../spec_schema/case.schema.json\n"
    assert squiggles(server, path, modeline + path.read_text("utf-8")) == []


def test_a_prefab_is_not_taken_for_a_case(server, case):
    text = MODELINE + "text2sim: 2\nprefab: cube\nbody: {kind: rigid, shape: {kind: box, size: [1, 1]}}\n"
    ((where, why),) = squiggles(server, case, text)
    assert (where, "Expected 3" in why) == ("[1, 1]", True)
