"""Measures of several bodies: a list means all that its selectors mean, together."""

import numpy as np
import pytest


@pytest.fixture
def heap(new_run):
    """Trunks of 1, 2 and 3 kg at (k, 0, 0) m that go k m/s along x, by their number k, and a drum that turns."""
    run = new_run(duration=0.1)
    floor = run.add_link("floor", fixed=True, mass=1e9)
    for k in (1, 2, 3):
        way = np.outer(k + k * run.time, [1, 0, 0])
        link = run.add_link(f"trunk_{k}", mass=float(k), pos=way, vel=(float(k), 0, 0))
        run.add_box(link, [0.1 * k] * 3)
        run.touch(floor, link, range(1, 11), (0, 0, 10.0 * k), depth=0.001 * k)
    run.touch(1, 2, range(1, 11), (5.0, 0, 0), depth=0.004)
    for number, name in enumerate(("drum", "door"), 1):
        run.add_joint(name, name, "hinge", q=number * run.time, link=run.add_link(name))
    return run.write()


ALL = ["trunk_1", "trunk_2", "trunk_3"]
TWO = {"of": ["trunk_3", "trunk_1"]}


@pytest.mark.parametrize(
    ("wanted", "last"),
    [
        # At 0.1 s they have gone 0.1, 0.2 and 0.3 m.
        ({"kind": "displacement", "of": ALL, "stat": "max"}, 0.3),
        ({"kind": "displacement", "of": ALL, "stat": "sum"}, 0.6),
        ({"kind": "displacement", "of": ALL, "stat": "count", "above": 0.15}, 2),
        ({"kind": "position", "axis": "x", "stat": "mean"} | TWO, 2.2),
        ({"kind": "speed", "stat": "range"} | TWO, 2.0),
        ({"kind": "extent", "axis": "x", "stat": "range"} | TWO, 3.3 + 0.3 - (1.1 - 0.1)),
        ({"kind": "momentum", "axis": "x"} | TWO, 1 * 1 + 3 * 3),
        ({"kind": "energy", "part": "kinetic"} | TWO, (1 * 1**2 + 3 * 3**2) / 2),
        ({"kind": "angular_momentum", "axis": "y", "about": [0, 0, -1]} | TWO, 1 * 1 + 3 * 3),
        ({"kind": "count_in", "of": ALL, "region": {"kind": "box", "min": [2, -1, -1], "max": [4, 1, 1]}}, 2),
        ({"kind": "joint_position", "of": ["drum", "door"], "stat": "sum"}, 0.1 + 0.2),
        ({"kind": "bend", "of": ["drum", "door"], "stat": "max"}, np.degrees(0.2)),
        # The first trunk pushes the second with 5 N, the floor all of them; what is between two of a list cancels.
        ({"kind": "contact_force", "of": "trunk_2", "by": ["trunk_1", "trunk_3"]}, 5),
        ({"kind": "contact_force", "of": ALL}, 60),
        ({"kind": "contact_count", "of": ["trunk_1", "trunk_2"], "by": ["floor", "trunk_2"]}, 3),
        ({"kind": "penetration"} | TWO, 0.004),
        ({"kind": "penetration", "by": ["floor"]} | TWO, 0.003),
        # A list of one is that one, and what is named twice counts once.
        ({"kind": "displacement", "of": ["trunk_2"]}, 0.2),
        ({"kind": "displacement", "of": ["trunk_2", "trunk_2"]}, 0.2),
        ({"kind": "momentum", "of": ["trunk_2", "trunk_2"], "axis": "x"}, 4),
        ({"kind": "joint_position", "of": ["drum", "drum.drum"]}, 0.1),
    ],
)
def test_a_list_is_all_that_it_names_together(heap, measure, wanted, last):
    series = measure(heap, bodies=(*ALL, "drum", "door"), **wanted)
    assert series.problem == ""
    assert series.values[-1] == pytest.approx(last, rel=1e-5)


def test_copies_and_links_in_a_list_count_once(new_run, measure):
    run = new_run(duration=0.1)
    for i in range(3):
        run.add_link(f"brick[{i}]", mass=2.0, vel=(1.0, 0, 0))
    run.add_link("arm", link="upper", mass=1.0, vel=(4.0, 0, 0))
    run.add_link("arm", link="hand", mass=3.0)
    folder, bodies = run.write(), ("brick", "arm")
    push = {"kind": "momentum", "axis": "x", "bodies": bodies}
    assert measure(folder, of=["brick[1]", "brick[0:2]", "brick"], **push).values[0] == 6.0
    assert measure(folder, of=["arm.upper", "arm", "brick[0]"], **push).values[0] == 6.0
    assert measure(folder, of=["arm.upper", "arm"], kind="speed", stat="sum", bodies=bodies).values[0] == 4.0 + 1.0
    number = {"kind": "speed", "bodies": bodies, "stat": "count", "below": 9.0}
    assert measure(folder, of=["brick[1]", "brick[0:2]", "brick"], **number).values[0] == 3
    assert "arm, brick means 4 bodies" in measure(folder, of=["arm", "brick"], kind="speed", bodies=bodies).problem
    assert "3 copies" in measure(folder, of=["brick", "brick[7]"], **number).problem


def test_contacts_within_a_body_count_where_its_links_are_named(new_run, measure):
    run = new_run(duration=0.1)
    floor = run.add_link("floor", fixed=True, mass=1e9)
    links = [run.add_link("cord", link=name) for name in ("link_1", "link_2", "link_3")]
    for pair in ((floor, links[0]), (floor, links[1]), (links[0], links[2]), (links[1], links[2])):
        run.touch(*pair, range(1, 11), (0, 0, 1.0))
    folder = run.write()
    count = {"kind": "contact_count", "bodies": ("cord",)}
    strands = measure(folder, of=["cord.link_*"], by=["cord.link_*"], **count)
    assert (strands.problem, strands.values[-1]) == ("", 2), "the cord lies on itself in two places"
    assert measure(folder, of="cord", **count).values[-1] == 1, "a body touches one other, the floor"
    assert measure(folder, of=["cord.link_*"], **count).values[-1] == 2, "two links touch the floor"
    assert measure(folder, of=["cord.link_*"], by=["floor"], **count).values[-1] == 2
    assert measure(folder, of="floor", by=["cord.link_2", "cord.link_3"], **count).values[-1] == 1
