"""View of an attempt for the Critic: all of it, or little where only looks can have changed."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from text2sim.agents import revising
from text2sim.agents.attempts import Attempt, changed
from text2sim.agents.criticism import Exhibit
from text2sim.agents.facts import Fact
from text2sim.agents.models.exchange import Image
from text2sim.agents.restyling import physics
from text2sim.agents.run_summary import attempts_table, judgement
from text2sim.spec_schema.errors import Text2SimError

GLANCE = 800
"""Width [pixels] of the pictures that tell whether a change of looks came out."""


def exhibit(
    made: Sequence[Attempt], attempt: Attempt, evidence: str, images: tuple[Image, ...], base: str, path: Path
) -> Exhibit:
    """Return what the Critic is shown.

    Args:
        made: All attempts.
        attempt: The last one.
        evidence: What is known of it.
        images: Its pictures.
        base: The case of which somebody wishes a change; empty if there was none.
        path: Where the case stands.
    """
    missed = attempt.missed(list(attempt.expect))
    cites, facts = frozenset(attempt.cites), tuple(Fact(**row) for row in attempt.facts)
    if base and not missed and attempt.state == "finished" and only_looks(base, attempt.text, path):
        rows = "\n".join(f"- {line}" for line in revising.change_lines(base, attempt.text))
        told = (
            f"Nothing but looks and film differ from the case as it was, so that the motion is the same: all "
            f"{len(attempt.expect)} expectations are true.\n\n{rows}\n\nA change is judged by the pictures. If "
            "something has to be mended, say what in `failures`; patches are not needed."
        )
        return Exhibit(attempt.number, "", told, cites, tuple(map(_smaller, images)), missed, facts)
    return Exhibit(attempt.number, attempt.text, evidence, cites, images, missed, facts, judgements(made))


def judgements(made: Sequence[Attempt]) -> str:
    """What the Critic said of earlier attempts, what became of it, and how expectations went over all of them."""
    earlier = [one for one in made[:-1] if one.number]
    if not earlier:
        return ""
    rows = [judgement(one.number, one.cause, one.critique, one.fates) for one in earlier]
    return "\n\n".join([*rows, attempts_table([(one.number, one.expect) for one in made if one.expect])])


def with_effects(made: Sequence[Attempt], attempt: Attempt) -> str:
    """The evidence of the last attempt, and what was changed since the one before and what that did."""
    earlier = [other for other in made[:-1] if other.expect]
    if not earlier or not attempt.changes:
        return attempt.evidence
    turned = changed(earlier[-1].expect, attempt.expect)
    rows = [f"- changed: {line}" for line in attempt.changes[:15]] + [f"- {row}" for row in turned]
    return f"{attempt.evidence}\n\n## Since attempt {earlier[-1].number}\n\n" + "\n".join(rows)


def kept(attempt: Attempt) -> list[str]:
    """What holds in an attempt, so that whoever changes it leaves that alone."""
    marks = (attempt.critique or {}).get("requirements", {})
    rows = [f"{name}: {row['why']}" for name, row in attempt.expect.items() if row.get("ok") is True]
    rows += [f"requirement {name} is met" for name, row in marks.items() if row["mark"] == 1]
    if rows:
        rows.append("everything that the instruction does not name: no other value, name or place changes")
    return rows


def only_looks(before: str, after: str, path: Path) -> bool:
    """Whether two versions of a case differ in nothing that physics could feel, and that is measured or expected."""
    try:
        return physics(before, path) == physics(after, path)
    except Text2SimError:
        return False  # of a case that cannot be worked out nothing is known


def _smaller(image: Image) -> Image:
    """The picture at a glance."""
    from PIL import Image as Picture

    with Picture.open(BytesIO(image.data)) as picture:
        small = picture.convert("RGB")
    small.thumbnail((GLANCE, GLANCE))
    out = BytesIO()
    small.save(out, "PNG", optimize=True)
    return Image(image.name, "image/png", out.getvalue())
