"""Recorded judgements of requests outside of the suite: they give the rows of docs/evaluation_results.md."""

import json
from pathlib import Path
from statistics import mean

import pytest

from tests.evaluation.recorded_scores import total
from text2sim.agents.models.parsing import read_reply
from text2sim.evaluation.statistics import estimate
from text2sim.evaluation.suite import read_suite

HERE = Path(__file__).parent
ROWS = json.loads((HERE / "recorded" / "user_requests.json").read_text("utf-8"))["rows"]
PAGE = (HERE.parents[1] / "docs" / "evaluation_results.md").read_text("utf-8")
PROMPTS = read_suite(HERE / "recorded" / "user_requests.yaml")[0].prompts
INTERRUPTED = ("awning_melons", "wobble_towers")
COUNTED = [prompt for prompt in PROMPTS if prompt not in INTERRUPTED]
FIVE_MORE, THREE_MORE, TWO_MORE, LAST, LATEST, NEXT, LETTERS, NEWEST, CROWDED, BELLS, STRAPS, PLEATS, BIAS, LADDERS = (
    COUNTED[4:9],
    COUNTED[9:12],
    COUNTED[12:14],
    COUNTED[14:19],
    COUNTED[19:23],
    COUNTED[23:26],
    COUNTED[26:29],
    COUNTED[29:33],
    COUNTED[33:36],
    COUNTED[36:38],
    COUNTED[38:40],
    COUNTED[40:43],
    COUNTED[43:45],
    COUNTED[45:],
)
METHODS, KINDS = ("text2sim-with-cards", "agent-no-cards"), ("physical", "visual")
BEARINGS = ("action.blue_sinks", "action.sideways", "scene.rulers")
LATE = ("comes_out", "cork_out", "pressed", "pulled", "soaped_out", "wedged")  # that its run did not get to
AGAIN = {"three_joined_vessels": "film traced again", "band_bundles_tubes": "played again"}


def mark(prompt, method, kind):
    marks = [
        total(row, PROMPTS) for row in ROWS if (row["prompt"], row["method"], row["kind"]) == (prompt, method, kind)
    ]
    assert len(marks) == (3 if prompt in COUNTED[:4] else 2), "judges"
    return mean(marks)


@pytest.mark.parametrize("prompt", PROMPTS)
def test_kept_replies_give_the_rows(prompt):
    cells = [f"{mark(prompt, method, kind):.1f}" for method in METHODS for kind in KINDS]
    assert f"| `{prompt}` | {' | '.join(cells)} |" in PAGE


@pytest.mark.parametrize(("prompt", "how"), AGAIN.items())
def test_what_was_shown_to_new_judges_has_its_row(prompt, how):
    methods = (f"text2sim-with-cards, {how}", "agent-no-cards, again")
    cells = [f"{mark(prompt, method, kind):.1f}" for method in methods for kind in KINDS]
    assert f"| `{prompt}`, {how} | {' | '.join(cells)} |" in PAGE


def test_means_and_differences_are_those_of_the_page():
    means = [mean(mark(prompt, method, kind) for prompt in COUNTED) for method in METHODS for kind in KINDS]
    assert f"| mean of the user requests | {' | '.join(f'{cell:.1f}' for cell in means)} |" in PAGE
    parts = {
        "first four": COUNTED[:4],
        "five more": FIVE_MORE,
        "three more": THREE_MORE,
        "two more": TWO_MORE,
        "last five": LAST,
        "four after them": LATEST,
        "three after those": NEXT,
        "three letter by letter": LETTERS,
        "newest four": NEWEST,
        "crowded three": CROWDED,
        "bell and belts": BELLS,
        "chimney and straps": STRAPS,
        "sleeves, jars and pleats": PLEATS,
        "bias cuts and stoppers": BIAS,
        "bearings, statues and ladders": LADDERS,
    }
    for name, some in (parts | {"user requests": COUNTED}).items():
        found = [estimate([mark(p, METHODS[0], kind) - mark(p, METHODS[1], kind) for p in some]) for kind in KINDS]
        cells = [f"{x.mean:+.1f} [{x.low:+.1f}, {x.high:+.1f}]".replace("-", "−") for x in found]
        assert f"| {name} | {len(some)} | {' | '.join(cells)} |" in PAGE


def test_what_was_marked_below_one():
    below = {
        (row["prompt"], row["method"], name)
        for row in ROWS
        if row["kind"] == "physical" and row["prompt"] in COUNTED and row["method"] in METHODS
        for name, one in read_reply(row["reply"])[0]["requirements"].items()
        if one["mark"] < 1
    }
    bare, ours = METHODS[1], METHODS[0]
    assert below == {
        *(("washing_line_pegs", bare, name) for name in ("action.lawn", "render.folds")),
        *(("breakfast_contraption", ours, name) for name in ("body.seesaw", "render.whole")),
        *(("rubber_flickers", ours, name) for name in ("body.bar", "render.view")),
        *(("tipping_bucket_gush", ours, name) for name in ("action.fills", "action.floats", "render.blue")),
        ("tipping_bucket_gush", bare, "body.water"),
        ("sand_tubes_pins", ours, "action.spread"),
        ("lump_under_rug", bare, "render.view"),
        *(("lump_under_rug", ours, name) for name in ("scene.tacked", "body.rug", "action.topple", "action.flat")),
        ("lump_under_rug", ours, "render.view"),
        *(("firewood_round_or_split", bare, name) for name in ("action.still", "action.spreads", "action.heap")),
        ("firewood_round_or_split", ours, "action.spreads"),
        ("shopping_trolleys_nest", bare, "scene.ground"),
        ("bollard_turns_of_rope", ours, "action.held"),
        *(("hanging_soup_tray", bare, name) for name in ("action.spills", "action.missing", "action.swings")),
        *(("hanging_soup_tray", ours, name) for name in ("action.spills", "action.missing")),
        ("slippery_pear_squirt", bare, "action.flattens"),
        ("battery_bin_flaps", bare, "action.pressed"),
        *(("three_joined_vessels", bare, name) for name in ("body.jug", "body.water")),
        *(("three_joined_vessels", ours, name) for name in ("body.jug", "action.level")),
        *(("wave_carries_crate", bare, name) for name in ("scene.calm", "action.bob")),
        *(("roman_blind_rods", bare, name) for name in ("body.cords", "action.still", "action.swags")),
        *(("roman_blind_rods", ours, name) for name in ("body.inextensible", "action.still", "action.level")),
        ("band_bundles_tubes", ours, "body.band"),
        ("finger_two_links", bare, "render.diagonal"),
        ("sail_carts_race", ours, "render.shading"),
        ("rover_six_wheels", bare, "action.green_contact"),
        ("rover_six_wheels", ours, "scene.lanes"),
        *(("stilts_in_sand", bare, f"action.{name}") for name in ("deep", "funnel", "rolls", "prints")),
        *(("stilts_in_sand", bare, name) for name in ("body.grains", "render.raised", "render.low_light")),
        *(("stilts_in_sand", ours, f"action.{name}") for name in ("deep", "carried", "funnel", "rolls", "prints")),
        *(("stilts_in_sand", ours, name) for name in ("scene.sandbox", "body.grains", "render.low_light")),
        *(("three_clocks_falling_weights", ours, name) for name in ("render.front", "render.claws")),
        *(("mattress_block_or_pockets", ours, f"action.{name}") for name in ("lowered", "heaves", "picked", "flat")),
        ("mattress_block_or_pockets", ours, "render.low_front"),
        ("fire_escape_tube", bare, "action.cones"),
        *(("fire_escape_tube", ours, f"action.{name}") for name in ("cones", "child", "empty")),
        *(("fire_escape_tube", ours, f"render.{name}") for name in ("oblique", "stripes")),
        ("bell_that_kept_silent", ours, "render.front"),
        *(("belt_climbs_the_crown", bare, name) for name in ("body.brake", "action.runs_off", "render.stripe")),
        *(("belt_climbs_the_crown", ours, name) for name in ("action.pushed", "action.stops", "render.high_front")),
        *(("rip_stitch_straps", bare, name) for name in ("body.straps", "action.hang")),
        *(("rip_stitch_straps", ours, f"action.{name}") for name in ("rows", "brakes", "hang")),
        *(("rip_stitch_straps", ours, name) for name in ("body.stitches", "render.folds")),
        *(("sleeve_arms_market_stall", bare, name) for name in ("body.sleeves", "render.daylight", "scene.posts")),
        *(("sleeve_arms_market_stall", method, "scene.greased") for method in METHODS),
        *(("jars_that_turn_again", bare, f"action.{name}") for name in ("again", "goes_round", "spun", "stopped")),
        *(("jars_that_turn_again", bare, name) for name in ("body.jars", "body.water", "render.surface")),
        *(("jars_that_turn_again", bare, f"scene.{name}") for name in ("pads", "turntables")),
        *(("jars_that_turn_again", ours, f"action.{name}") for name in ("again", "goes_round", "jelly_stays", "spun")),
        *(("jars_that_turn_again", ours, name) for name in ("body.jars", "render.surface")),
        *(("pleated_sheet_bridges", method, "render.below") for method in METHODS),
        *(
            ("bias_cut_check_panels", bare, f"action.{name}")
            for name in ("back", "green", "knocked", "longer", "red", "waist")
        ),
        *(("bias_cut_check_panels", method, "body.panels") for method in METHODS),
        ("bias_cut_check_panels", ours, "action.still"),
        *(("stoppers_pushed_and_pulled", bare, name) for name in ("action.pulled", "scene.rams")),
        *(
            ("stoppers_pushed_and_pulled", method, name)
            for method in METHODS
            for name in ("action.sits", "body.rubber")
        ),
        *(("stoppers_pushed_and_pulled", ours, f"action.{name}") for name in LATE),
        *(("stoppers_pushed_and_pulled", ours, f"body.{name}") for name in ("bands", "cork", "soaped")),
        ("stoppers_pushed_and_pulled", ours, "render.front"),
        *(("bridge_bearings_sheets", method, name) for method in METHODS for name in BEARINGS),
        ("bridge_bearings_sheets", bare, "action.orange_sinks"),
        *(("statue_unveiling_lines", bare, f"action.{name}") for name in ("quiet", "rises", "topples")),
        *(("statue_unveiling_lines", bare, name) for name in ("body.cloths", "body.fastened", "scene.lines")),
        *(("statue_unveiling_lines", bare, f"render.{name}") for name in ("folds", "front")),
        ("statue_unveiling_lines", ours, "body.lead"),
        *(("orchard_ladders_slip", method, "scene.wall") for method in METHODS),
    }
