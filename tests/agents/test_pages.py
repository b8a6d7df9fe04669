"""Pages of the language in letters: what their readers need, and no more."""

from math import asin, degrees, hypot
from pathlib import Path
from typing import get_args

import pytest

from text2sim.agents import language
from text2sim.agents.kind_words import kinds_in
from text2sim.agents.page_selection import KINDS_BY_PAGE
from text2sim.compiler.film_lights import STUDIOS
from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.events import Event
from text2sim.spec_schema.models.measures import Measure
from text2sim.spec_schema.models.repeat import Repeat
from text2sim.spec_schema.models.space import Region
from text2sim.spec_schema.published.language_reference import section_kinds


def test_a_script_of_rigid_bodies_hears_nothing_of_what_deforms() -> None:
    rigid, soft = (language.reference_pages("actions", kinds) for kinds in ({"attach", "drive"}, {"attach", "cloth"}))
    assert "turn about a `pivot`. Two links that are attached do not collide" in rigid
    for word in ("clamps", "its holder", "curtain"):
        assert word in soft
        assert word not in rigid


def test_times_of_schedules_are_said_to_be_those_of_the_run_or_since_an_event() -> None:
    page = language.reference_pages("actions", {"drive", "force"})
    assert (
        "Times are relative to the start of the run, also for a control with `during`, but to the event for a drive with `on`"
        in page
    )


def test_what_a_name_says_itself_is_named_and_no_more() -> None:
    text = language.vocabulary()
    assert "- `plane`, `box`, `sphere`," in text
    assert "- `cone`: A cone along z with its tip up" in text
    assert "`plate`," in text


def test_the_planner_reads_how_parts_of_a_cloth_are_measured_and_what_expectations_take() -> None:
    text = language.to_plan_with()
    assert "`region` of what deforms: a part of it, as `{edge: left}`" in text
    for word in ("within", "count", "before", "never", "at", "during", "stat", "above", "below", "equals", "tolerance",
                 "swing"):  # fmt: skip
        assert f"`{word}" in text.partition("## Expectations")[2]
    assert len(text) < 5_750, "every plan costs this text: shorten the docstrings of measures, or raise it on purpose"


def test_everyday_words_for_a_strip_lead_to_beams() -> None:
    line = next(row for row in language.vocabulary().split("\n") if row.startswith("- `beam`"))
    for word in ("strip", "slat", "springboard", "ruler", "leaf spring", "reed", "catapult"):
        assert word in line, "the Planner chooses by this line"
    assert "- `youngs_modulus`* (> 0)" in language.named_reference("bodies", "make the springboard stiffer")
    assert "beam" not in kinds_in({"strip", "spring", "board"})


def test_all_kinds_with_a_region_of_space_require_its_page() -> None:
    kinds = section_kinds(Measure) | section_kinds(Event) | section_kinds(Repeat)
    regions = {kind: field.annotation for kind, model in kinds.items() if (field := model.model_fields.get("region"))}
    with_region = {kind for kind, taken in regions.items() if {taken, *get_args(taken)} & {Region, get_args(Region)[0]}}
    assert KINDS_BY_PAGE["Regions of space"] ^ with_region == set(), "missing there, or gone from the language"


@pytest.mark.parametrize("kind", sorted(section_kinds(Body)))
def test_the_planner_hears_that_every_kind_of_body_runs(kind: str) -> None:
    prompt = Path(language.__file__).parent / "prompts/plan.md.j2"
    assert f"`{kind}`" in prompt.read_text("utf-8").partition("What runs here:")[2], "it lists what runs"


def test_where_the_sun_of_a_lighting_stands_is_said_as_it_is() -> None:
    page = language.reference_pages("render", {"still"})
    for name, words in (
        ("sunlight", "a sun of {:g}, {:.0f} deg high"),
        ("golden_hour", "a warm sun of {:g}, {:.0f} deg high"),
    ):
        sun = STUDIOS[name].lights["sun"]
        assert words.format(sun.strength, degrees(asin(-sun.direction[2] / hypot(*sun.direction)))) in page
        assert sun.direction[0] > 0 < sun.direction[1], "from the left behind the camera"


def test_a_film_whose_brief_speaks_of_a_mounted_camera_hears_how_one_is_written() -> None:
    words = "a camera mounted on the hand".split()
    page = language.reference_pages("render", kinds_in(words))
    assert "- `on`* (selector): What carries it" in page
    assert "`mounted`" in language.reference_pages("render", {"still"}).partition("Other kinds: ")[2]


def test_fields_that_no_writer_has_a_use_for_are_left_out() -> None:
    scene, film, bodies = (
        language.reference_pages(reader, {"rigid", "box", "still"}) for reader in ("scene", "render", "bodies")
    )
    assert "- `seed`" not in scene
    assert "- `density`" not in scene, "a static needs no mass"
    assert "- `density`" in bodies
    assert "- `quality`" not in film
    assert "**Overlay.**" not in film
    assert "A line of text at the lower left" in language.explanations(["Overlay"])[0], (
        "whoever has to write into pictures asks"
    )


def test_the_planner_reads_what_kinds_can_do_and_not_how_they_are_written() -> None:
    names = ["rope", "hinge", "drive", "extent"]
    (told, _), (planned, _) = (language.explanations(names, examples=shown) for shown in (True, False))
    assert "belt:" in told and "e.g. `mount:" in told and "lift: {kind: drive" in told
    assert "belt:" not in planned and "e.g. `mount:" not in planned and "lift: {kind: drive" not in planned
    assert "`self_collision` (bool; false): Let links" in planned
    assert "## Controls" in planned, "what follows an example is left"
    assert "kind: extent" in planned, "measures are the Planner's own to write"


def test_copies_are_told_apart_where_there_are_any() -> None:
    one, several = (language.reference_pages("bodies", {"rigid", *kinds}) for kinds in ((), ("line",)))
    assert "- `vary`" in several and "vary: {value" in several
    assert "- `vary`" not in one and "vary: {value" not in one
    assert "look: {color: terracotta, finish: rough}" in one


def test_fields_of_two_bases_stand_under_one_heading() -> None:
    page = language.explanation("still")
    assert page.count("Besides its own fields, `still` has:") == 1
    assert "- `frame`" in page and "- `up`" in page


def test_who_asks_for_a_shape_gets_neither_cloth_nor_sculpts() -> None:
    text, _ = language.explanations(["box"])
    assert "## Shapes\n" in text
    assert "cushion" not in text and "rounding" not in text
    assert "cushion" in language.explanations(["Shapes of cloth"])[0]


def test_letters_say_nothing_twice_and_nothing_of_what_deforms_where_nothing_does() -> None:
    plan = language.to_plan_with()
    assert "- `enters`, `leaves`: A body's origin enters or leaves a region" in plan
    assert plan.count("kind: box, min:") == 1, "the form of a region is shown once"
    rigid, soft = (language.reference_pages("scene", {"box", *kinds}) for kinds in ((), ("soft",)))
    assert "whose solvers do not check" not in rigid
    assert "whose solvers do not check" in soft
    assert "by default 1000" in rigid
    assert "coefficient of rolling resistance" in rigid
    assert "do not resist rolling" not in rigid
    assert "milk or paint" not in rigid
    joints = "The joint of a rigid body"
    assert joints in language.rules(brief=True, reader="bodies")
    assert joints not in language.rules(brief=True, reader="render")
    kinds = language.kinds_to_expect_with(deformable=False).split(", ")
    assert "pieces" in kinds, "bonds of rigid bodies break, too"
    assert "stretch" not in kinds
    assert {*kinds} < {*language.kinds_to_expect_with().split(", ")}


@pytest.mark.parametrize(("one", "page"), [("camera", "Cameras"), ("Schedule", "Schedules"), ("events", "Events")])
def test_a_page_is_found_by_its_singular(one: str, page: str) -> None:
    assert language.explanation(one) == language.explanation(page)
    assert f"## {page}" in language.explanation(one)


def test_who_asks_for_a_kind_reads_what_its_parts_are_made_of() -> None:
    compound = language.explanation("compound")
    assert "Only draw the piece" in compound, "`decor` of a part"
    assert "Only draw the piece" not in language.explanation("compound", examples=False), "the Planner writes none"
    tank = language.prefabs(only={"tank"})
    assert "`width` (a length [m] from 0.05 to 5; 0.3) Inside, along x." in tank
    assert "Inside, along x." not in language.prefabs(), "the list of all is short"
    assert "`within` ({min: [x, y, z], max: [x, y, z]})" in language.reference_pages("render", {"still"})
