"""A line of the table of physics checks."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """What was measured, beside what an equation says."""

    check: str
    """What is compared, with its unit."""
    solver: str
    """Solver and how fine it was."""
    theory: float
    measured: float
    whole: float | None = None
    """What the error is a part of, where it is not the theory."""

    @property
    def error(self) -> float:
        """Relative error."""
        return (self.measured - self.theory) / (self.theory if self.whole is None else self.whole)


def table(rows: list[Row]) -> str:
    """Return rows as Markdown."""
    lines = ["| check | solver | theory | measured | error |", "|---|---|---|---|---|"]
    lines += [
        f"| {row.check} | {row.solver} | {row.theory:.4g} | {row.measured:.4g} | {100 * row.error:+.1f} % |"
        for row in rows
    ]
    return "\n".join(lines)
