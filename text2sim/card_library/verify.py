"""Verification of cards: their cases are run, and the outcomes compared with those on the card."""

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim.card_library.library import CardEntry, check_entry
from text2sim.spec_schema.errors import RunError, SpecError, Text2SimError
from text2sim.spec_schema.loaded import LoadedCase

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.runtime.stop import Stop

TIMEOUT = 300.0
"""Limit of the wall time of a case [s]."""


@dataclass(frozen=True)
class Verdict:
    """Result of verifying a card."""

    id: str
    ok: bool
    failing: str
    """Outcome of the failing case."""
    repaired: str
    """Outcome of the repaired case."""
    message: str = ""
    """Reasons if the card does not hold."""
    wall: float = 0.0
    """Wall time [s]."""

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        return asdict(self) | {"wall": round(self.wall, 3)}


def verify_cards(
    entries: Iterable[CardEntry],
    *,
    runs: Path,
    jobs: int = 1,
    timeout: float = TIMEOUT,
    simulate: bool = True,
    force: bool = False,
) -> Iterator[Verdict]:
    """Check cards, and run their cases without film.

    Args:
        entries: The cards.
        runs: Folder of run folders; finished runs in it are reused.
        jobs: Number of cards that are verified at a time.
        timeout: Limit of the wall time of each case [s].
        simulate: Whether to run the cases; otherwise, only outcomes of the lint are compared.
        force: Whether to simulate again even if nothing has changed.

    Yields:
        A verdict for each card, in their order, until the user asks to stop.
    """
    from concurrent.futures import ThreadPoolExecutor

    from text2sim.runtime.stop import Stop

    options: dict[str, Any] = {"runs": runs, "timeout": timeout, "simulate": simulate, "force": force}
    with Stop() as stop, ThreadPoolExecutor(max_workers=max(jobs, 1)) as pool:
        waiting = [pool.submit(verify_card, entry, stop=stop, **options) for entry in entries]
        try:
            # Signals reach this thread; the programs run in the others, which read the counter.
            with stop.gently():
                for future in waiting:
                    verdict = future.result()
                    if stop.count:
                        return
                    yield verdict
        finally:
            for future in waiting:
                future.cancel()


def verify_card(
    entry: CardEntry,
    *,
    runs: Path,
    timeout: float = TIMEOUT,
    simulate: bool = True,
    force: bool = False,
    stop: "Stop | None" = None,
) -> Verdict:
    """Check a card, run its cases, and compare the outcomes; see `verify_cards`.

    Args:
        entry: The card.
        runs: Folder of run folders.
        timeout: Limit of the wall time of each case [s].
        simulate: Whether to run the cases, not only the lint.
        force: Whether to simulate again even if nothing has changed.
        stop: Requests to stop.

    Raises:
        MachineError: if this machine cannot run a case.
    """
    begun = monotonic()
    try:
        card, bad, good = check_entry(entry)
    except SpecError as error:
        message = "; ".join(str(problem) for problem in error.problems[:3])
        return Verdict(entry.id, False, "", "", message, monotonic() - begun)
    options: dict[str, Any] = {"runs": runs, "timeout": timeout, "force": force, "stop": stop}
    wanted = card.evidence.failing.outcome
    by_lint = wanted.startswith("lint:")
    seen = _outcomes(bad, simulate=simulate and not by_lint, **options)
    repaired = _outcomes(good, simulate=simulate, **options)
    reasons = []
    if by_lint or simulate:
        if wanted not in seen:
            reasons.append(f"the failing case should be `{wanted}` (is: {_outcomes_text(seen)})")
        elif wanted in repaired:
            reasons.append(f"the repaired case is still `{wanted}`")
    if simulate and "passed" not in repaired:
        reasons.append(f"the repaired case should pass (is: {_outcomes_text(repaired)})")
    elif not simulate and "error" in repaired:
        reasons.append("the lint finds errors in the repaired case")
    shown = wanted if wanted in seen else _outcomes_text(seen)
    ended = "passed" if "passed" in repaired else _outcomes_text(repaired)
    return Verdict(entry.id, not reasons, shown, ended, "; ".join(reasons), monotonic() - begun)


def _outcomes(loaded: LoadedCase, *, simulate: bool, **options: Any) -> list[str]:
    """All outcomes of a case; besides those of cards, `error` if it cannot be run, and `state:…` for any early end."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    try:
        report = lint_case(resolve_case(loaded))
    except Text2SimError as error:
        return [*(f"lint:{problem.rule}" for problem in getattr(error, "problems", ())), "error"]
    found = [f"lint:{problem.rule}" for problem in report.problems]
    if not report.ok:
        return [*found, "error"]
    return [*found, *_run(loaded, **options)] if simulate else found


def _run(loaded: LoadedCase, *, stop: "Stop | None" = None, **options: Any) -> list[str]:
    from text2sim.harness.run import run_case

    if stop is not None and stop.count:
        return ["state:interrupted"]
    try:
        result: RunResult = run_case(loaded, film=False, stop=stop, **options)
    except (SpecError, RunError):
        return ["error"]
    if result.state != "finished":
        return [f"state:{result.state}"]
    missed = [f"missed:{name}" for name, row in result.expectations.items() if not row["ok"]]
    doubts = ["suspicion"] if result.suspicions else []
    return [*missed, *doubts, *(["passed"] if result.passed else [])]


def _outcomes_text(outcomes: list[str]) -> str:
    return ", ".join(dict.fromkeys(outcomes)) or "nothing of note"
