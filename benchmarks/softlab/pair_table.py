"""The table of the pairs."""

from benchmarks.softlab.families import FRICTION, pairs
from benchmarks.softlab.pairs import Finding


def markdown(findings: list[Finding]) -> str:
    """Return what was found as a Markdown table."""
    by_name = {finding.pair: finding for finding in findings}
    lines = [
        "| bodies | model | touch | both ways | momentum passed on | friction | |",
        "|---|---|---|---|---|---|---|",
    ]
    for pair in pairs():
        finding = by_name.get(pair.name)
        if finding is None:
            continue
        names = f"{pair.first} – {pair.second}" + (", in a scene with fem" if pair.is_extra else "")
        if finding.problem is not None:
            lines.append(f"| {names} | {pair.model} | fails | | | | {finding.problem} |")
            continue
        lines.append(
            f"| {names} | {pair.model} | {_touch(finding)} | {_two_way(finding)} | {_passed(finding)} "
            f"| {_friction(finding)} | {_note(finding)} |"
        )
    return "\n".join(lines)


def _touch(finding: Finding) -> str:
    return "yes" if finding.touches else "**no**"


def _two_way(finding: Finding) -> str:
    if not finding.touches:
        return ""
    return "yes" if finding.two_way else "**no**"


def _passed(finding: Finding) -> str:
    if not finding.touches:
        return ""
    return f"{finding.given:.2f} / {finding.lost:.2f}"


def _friction(finding: Finding) -> str:
    if not finding.touches or finding.friction is None:
        return ""
    if finding.friction < 0.1 * FRICTION:
        return "**none**"
    return f"{finding.friction:.2f}"


def _note(finding: Finding) -> str:
    notes = ["the first stands still in the air"] if finding.frozen else []
    if not finding.touches:
        return "; ".join([*notes, "the other goes through it" if finding.through else "they do not meet"])
    if finding.through:
        notes.append("ends beyond what it struck")
    if abs((finding.given or 0) - (finding.lost or 0)) > 0.1:
        notes.append("momentum is not kept")
    return "; ".join(notes)
