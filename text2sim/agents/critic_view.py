"""View of an attempt for the Critic: all of its evidence, or a short form if only its looks have changed."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from text2sim.agents import revising
from text2sim.agents.attempt import Attempt, changed_expectations
from text2sim.agents.criticism import Exhibit
from text2sim.agents.facts import Fact
from text2sim.agents.models.exchange import Image
from text2sim.agents.restyling import physics_digest
from text2sim.agents.run_summary import attempts_table, judgement_text, to_look_at
from text2sim.spec_schema.errors import Text2SimError

SHORT_FORM_SIZE = 800
"""Largest side of the pictures in the short form [pixels]."""


def critic_exhibit(made: Sequence[Attempt], evidence: str, images: tuple[Image, ...], base: str, path: Path) -> Exhibit:
    """Return the exhibit for the Critic of the latest attempt.

    Args:
        made: All attempts.
        evidence: Text of the latest attempt's evidence.
        images: Its images.
        base: Text of the existing case that is to be changed; empty for a new one.
        path: Path of the case file.
    """
    attempt = made[-1]
    missed = attempt.missed(list(attempt.expect))
    cites, facts = frozenset(attempt.cites), tuple(Fact(**row) for row in attempt.facts)
    if base and not missed and attempt.state == "finished" and only_looks(base, attempt.text, path):
        rows = "\n".join(f"- {line}" for line in revising.change_lines(base, attempt.text))
        sentence = (
            "Only looks and film differ from the earlier case, so the motion is the same, and all "
            f"{len(attempt.expect)} expectations are met.\n\n{rows}\n\nA change is judged by the pictures. If "
            "something needs fixing, name it in `failures`; patches are not needed."
        )
        return Exhibit(attempt.number, "", sentence, cites, tuple(map(_smaller, images)), missed, facts)
    if not missed and (before := _judged_before(made, path)) is not None:
        marks = before.critique["requirements"] if before.critique is not None else {}
        met = ", ".join(f"`{name}`" for name, row in marks.items() if row["mark"] == 1)
        evidence = (
            f"{to_look_at(evidence)}\n\nOnly looks and film differ from attempt {before.number}; the motion "
            f"is the same and was judged there. Met there, and so here unless the film hides it: {met or 'nothing'}."
        )
    return Exhibit(
        attempt.number, attempt.text, evidence, cites, images, missed, facts, earlier_judgements(made),
        finished=attempt.state == "finished",
    )  # fmt: skip


def _judged_before(made: Sequence[Attempt], path: Path) -> Attempt | None:
    """The latest attempt before the last one whose judged run it only films again; None if there is none."""
    attempt = made[-1]
    same = (one for one in reversed(made[:-1]) if one.critique is not None and one.run and one.run == attempt.run)
    return next((one for one in same if only_looks(one.text, attempt.text, path)), None)


def earlier_judgements(made: Sequence[Attempt]) -> str:
    """Return earlier judgements with the fate of their patches, and a table of expectations over all attempts."""
    earlier = list(made[:-1])
    if not earlier:
        return ""
    rows = [judgement_text(one.number, one.cause, one.critique, one.fates) for one in earlier]
    return "\n\n".join([*rows, attempts_table([(one.number, one.expect) for one in made if one.expect])])


def with_effects(made: Sequence[Attempt]) -> str:
    """Return the evidence of the latest attempt, with the changes since the previous one and their effects."""
    attempt = made[-1]
    earlier = [other for other in made[:-1] if other.expect]
    if not earlier or not attempt.changes:
        return attempt.evidence
    turned = changed_expectations(earlier[-1].expect, attempt.expect)
    rows = [f"- changed: {line}" for line in attempt.changes[:15]] + [f"- {row}" for row in turned]
    return f"{attempt.evidence}\n\n## Since attempt {earlier[-1].number}\n\n" + "\n".join(rows)


def what_holds(attempt: Attempt) -> list[str]:
    """Return what holds in an attempt and must stay true after the next change."""
    marks = (attempt.critique or {}).get("requirements", {})
    rows = [f"{name}: {row['why']}" for name, row in attempt.expect.items() if row.get("ok") is True]
    rows += [f"requirement {name} is met" for name, row in marks.items() if row["mark"] == 1]
    if rows:
        rows.append("everything that the instruction does not name: no other value, name or place changes")
    return rows


def only_looks(before: str, after: str, path: Path) -> bool:
    """Whether two versions of a case have the same physics, measures and expectations, controls included.

    Args:
        before: Text of the earlier version.
        after: Text of the later version.
        path: Path of the case file.
    """
    try:
        return physics_digest(before, path) == physics_digest(after, path)
    except Text2SimError:
        return False  # nothing is known of a case that cannot be resolved


def _smaller(image: Image) -> Image:
    """Return a reduced copy of an image."""
    from PIL import Image as Picture

    with Picture.open(BytesIO(image.data)) as picture:
        small = picture.convert("RGB")
    small.thumbnail((SHORT_FORM_SIZE, SHORT_FORM_SIZE))
    out = BytesIO()
    small.save(out, "PNG", optimize=True)
    return Image(image.name, "image/png", out.getvalue())
