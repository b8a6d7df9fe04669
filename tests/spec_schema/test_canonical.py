"""The canonical form: one order, one layout; the data and the comments stay."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_case import small

from text2sim.spec_schema.arithmetic.values import MIN_NUMBER
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.canonical import WIDTH, dump_case, format_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

UGLY = """\
# yaml-language-server: $schema=x.json
# A file by someone in a hurry.

name:   'wall'
text2sim: 1   # the version
render: {cameras: {main: {look_at: [0,0,0.35], kind: still, from: [2.6, -2.8, 1.3]}}}
# Above the bodies.
bodies:

    # The brick.
    brick:
        look: {color: "terracotta"}   # like a roof
        shape: {size: ${brick}, kind: box}
        kind: 'rigid'


        repeat: {kind: running_bond, columns: 6, rows: ${rows}}
        # Below the repeat.
    ball: {kind: rigid, shape: {radius: .15, kind: sphere}, material: {density: 7.8e+3}}
    # After the last body.
params:
    rows: 8
    brick:
      - 0.24   # long
      - 0.11
      - 0.07
    list: [1, 2,
           # inside
           3]
scene:
    statics: {floor: {shape: {kind: plane}}}
    duration: 1e0
actions:
    controls: {launch: {linear: [${speed}, 0, 0], body: ball, kind: initial_velocity},
        hold: {kind: attach, to: brick[3], body: ball}}
# The end.
"""

NEAT = """\
# yaml-language-server: $schema=x.json
# A file by someone in a hurry.

text2sim: 1  # the version
name: wall
params:
  rows: 8
  brick:
    - 0.24  # long
    - 0.11
    - 0.07
  list:
    - 1
    - 2
    # inside
    - 3

scene:
  duration: 1.0
  statics:
    floor: {shape: {kind: plane}}

# Above the bodies.
bodies:
  # The brick.
  brick:
    kind: rigid
    shape: {kind: box, size: "${brick}"}

    repeat: {kind: running_bond, rows: "${rows}", columns: 6}
    # Below the repeat.
    look: {color: terracotta}  # like a roof
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.15}
    material: {density: 7800.0}
  # After the last body.

actions:
  controls:
    launch: {kind: initial_velocity, body: ball, linear: ["${speed}", 0, 0]}
    hold: {kind: attach, body: ball, to: "brick[3]"}

render:
  cameras:
    main: {kind: still, from: [2.6, -2.8, 1.3], look_at: [0, 0, 0.35]}

# The end.
"""


def test_order_layout_and_comments():
    assert format_text(UGLY) == NEAT


def test_formatting_twice_changes_nothing():
    assert format_text(NEAT) == NEAT


def data_of(text: str):
    return parse_document(Source(text)).data


def test_the_data_stays_the_same():
    assert data_of(NEAT) == data_of(UGLY)


def test_a_case_need_not_be_valid_to_be_formatted():
    text = format_text("bodies: {b: {zebra: 1, kind: horse}}\nfoo: {on: off, 'no': yes, x: null}\n")
    assert text == 'bodies:\n  b:\n    zebra: 1\n    kind: horse\nfoo: {on: "off", no: "yes", x: null}\n'


def test_what_is_not_yaml_is_not_formatted():
    with pytest.raises(SpecError):
        format_text("a: {b: 1\n")


def test_long_text_is_folded_and_lines_are_kept():
    words = " ".join(["word"] * 60)
    text = format_text(small(top=f"prompt: {words}"))
    assert max(map(len, text.splitlines())) <= WIDTH
    assert load_text(text).case.prompt == words
    lines = format_text("text2sim: 1\nprompt: |\n  one: two\n\n  three # four\nname: a\n")
    assert lines == "text2sim: 1\nname: a\nprompt: |\n  one: two\n\n  three # four\n"


def test_long_lists_are_filled():
    times = ", ".join(str(i / 8) for i in range(100))
    text = format_text(f"bodies: {{a: {{kind: driven, motion: {{kind: waypoints, times: [{times}]}}}}}}\n")
    assert max(map(len, text.splitlines())) <= WIDTH
    assert len(text.splitlines()) < 15


@pytest.mark.parametrize("value", [
    "yes", "on", "12:30", "1e3", "010", "0x1F", "null", "~", "", " a", "a ", "a: b", "a #b", "#a", "-", "- a",
    "? a", "@a", "%a", "&a", "*a", "!a", "|", ">", "'", '"', "a\nb", "a\n", "\na", "a\tb", "a\\b", "${x}",
    "{a}", "[a", "a, b", "=", "<<", "2001-01-01", "1_000", "é", "日本", "🧱", "a:b", "a:", ":a", ".5", "1.",
    "+1", "y", "true", "line \u2028 end", "nbsp\u00a0x", "a  b", "$${x}", "it's", 'say "x"', "\x85",
])  # fmt: skip
def test_any_text_survives(value):
    text = dump_case({"name": value, "params": {"a": [value, {"b": value}], "b": value}, "prompt": value})
    assert data_of(text) == {
        "name": value,
        "prompt": value,
        "params": {"a": [value, {"b": value}], "b": value},
    }
    assert format_text(text) == text


@pytest.mark.parametrize("value", [0, -1, 10**14, 0.1, -2.5, 1e-7, 1.5e14, 1e-30, 1e15, 7800.0, True, False, None])
def test_any_number_survives(value):
    found = data_of(dump_case({"params": {"a": value, "b": [value]}}))["params"]
    assert found == {"a": value, "b": [value]}
    assert type(found["a"]) is type(value)


def test_what_has_no_words_is_not_written():
    for value in (float("nan"), float("inf")):
        with pytest.raises(ValueError):
            dump_case({"a": value})


def test_models_are_written_as_their_author_gave_them():
    text = format_text(small(ball=", mount: {kind: hinge, range_deg: [-10, 10]}", top="prompt: A ball."))
    loaded = load_text(text)
    assert load_text(dump_case(loaded.case)).case == loaded.case
    assert dump_case(loaded.written.data) == text


def test_other_tools_read_the_canonical_form():
    yaml = pytest.importorskip("yaml")
    data = yaml.safe_load(NEAT)
    assert data["bodies"]["brick"]["shape"]["size"] == "${brick}"
    assert data["actions"]["controls"]["hold"]["to"] == "brick[3]"


names = st.text(alphabet="abcxyz_09", min_size=1, max_size=6)
visible = st.characters(exclude_categories=["Cs", "Cc", "Co", "Cn", "Cf"])
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**12), 10**12),
    st.floats(-1e15, 1e15).filter(lambda x: x == 0 or abs(x) >= MIN_NUMBER),
    st.text(visible, max_size=20),
    st.sampled_from(["${a}", "x[3]", "on", "a b"]),
)
trees = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(names, inner, max_size=4),
    max_leaves=20,
)


@given(
    st.dictionaries(
        st.sampled_from(["bodies", "scene", "params", "actions", "render", "name", "zebra"]),
        trees,
        min_size=1,
    )
)
@settings(max_examples=80, deadline=None)
def test_any_data_survives(data):
    text = dump_case(data)
    assert data_of(text) == data
    assert format_text(text) == text


@pytest.mark.parametrize("text", ["# a\n{}\n", "# a\n# b\n[]\n\n# c\n", "# a\n5\n"])
def test_comments_stay_where_nothing_is_named(text):
    assert format_text(text) == text


comments = st.sampled_from(["", "", "  # c"])


@given(st.lists(st.tuples(st.integers(0, 2), names, comments, st.booleans(), st.booleans()), min_size=1, max_size=12))
@settings(max_examples=80, deadline=None)
def test_comments_survive_wherever_they_stand(rows):
    """Random outlines with comments above, beside and below their entries."""
    lines, depth, count = [], -1, 0
    for number, (level, name, beside, above, blank) in enumerate(rows):
        level = min(level, depth + 1)
        margin = "  " * level
        if blank:
            lines.append("")
        if above:
            lines.append(f"{margin}# above {number}")
            count += 1
        deeper = number + 1 < len(rows) and rows[number + 1][0] > level
        lines.append(f"{margin}{name}{number}:{'' if deeper else ' 1'}{beside}")
        count += bool(beside)
        depth = level
    lines.append("  # below")
    text = "\n".join(lines) + "\n"
    neat = format_text(text)
    assert neat.count("#") == count + 1
    assert format_text(neat) == neat
    assert data_of(neat) == data_of(text)
