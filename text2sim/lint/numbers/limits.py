"""Limits of the engine that a scene would overflow.

The engine keeps room for 5 contact points for each of `max_pairs` (`n_contacts_per_convex_pair`), and for 8 times
`max_pairs` pairs whose boxes overlap. More than that stops the run with an exception. A body that lies on a floor has
at least one point if it is round and four if it has flat sides.
"""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem

POINTS_OF_A_PAIR = 5
BROAD = 8
"""Pairs with overlapping boxes for each of `max_pairs`."""
ROUND = ("sphere", "ellipsoid")


def _pairs(facts: Facts) -> Iterator[Problem]:
    given = facts.case.scene.contact.max_pairs
    if given is None:
        return
    loose = [copy for copy in facts.moving if facts.free(copy)]
    points = sum(1 if getattr(copy.shape, "kind", "") in ROUND else 4 for copy in loose)
    where, usual = ("scene", "contact", "max_pairs"), max(150, 16 * facts.lowering.pieces)
    if points > POINTS_OF_A_PAIR * given:
        text = (
            f"gives room for {POINTS_OF_A_PAIR * given} points of contact, and the {len(loose)} loose bodies have "
            f"{points} as soon as all of them lie on something: the run would stop there; {-(-points // 2)} or more "
            f"are needed, and {usual} would be chosen if you leave it out"
        )
        yield facts.problem("few-pairs", where, text)
        return
    near = sum(1 for _ in facts.near())
    if near > BROAD * given:
        text = (
            f"gives room for {BROAD * given} pairs whose boxes overlap, and there are {near} at the start already: the "
            f"run would stop at once; leave it out, and {usual} will be chosen"
        )
        yield facts.problem("few-pairs", where, text)


_HEAP = """\
scene: {contact: {max_pairs: %d}}
bodies:
  cube:
    kind: rigid
    shape: {kind: box, size: [0.05, 0.05, 0.05]}
    pose: {pos: [0, 0, 0.05]}
    repeat: {kind: grid, counts: [6, 6, 2], spacing: 0.08}
"""

RULES = (
    Rule(
        id="few-pairs",
        severity="warning",
        title="`scene.contact.max_pairs` is too small for the bodies of the scene.",
        reason="""\
The engine makes room for five points of contact for each of `max_pairs`. As soon as there are more, the run stops with
an error. A body with flat sides that lies on something has four points, and in a heap three times as many.""",
        way_out="Leave it out: 16 for each convex piece has always been enough.",
        example=_HEAP % 40,
        mended=_HEAP % 1200,
        run=_pairs,
        own_contact=True,
    ),
)
