"""History of a loop: the versions that it has made, and what is left of its attempts and time."""

from copy import copy
from math import inf

from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempts import Attempts
from text2sim.agents.loop_result import LoopLimits

FIRST_RUN_SHARES = (0.45, 0.6)
"""Largest part of the time left that a run may be expected to take as long as none has finished: the first run, and one
after a first that was too slow. With more, no time would be left for another run."""
LATER_RUN_SHARE = 4 / 3
"""The same for any other run. It is above 1 because the estimate is about a third off; a run that clearly does not end
in time shows nothing that a coarser one would not show."""
RECENT_RUNS = 3
"""Number of the latest attempts; the longest of them predicts how long the next takes."""


class History:
    """Attempts of a loop, in the order in which they were made."""

    def __init__(self, attempts: Attempts, limits: LoopLimits) -> None:
        self.attempts, self.limits = attempts, limits
        self.made: list[Attempt] = []
        self.base = ""
        """Text of the existing case that is to be changed; empty for a new case."""
        self._agreed: dict[int, Agreement] = {}
        """The agreement at each attempt that ran, by number."""

    def begin(self, text: str, cause: str) -> Attempt:
        """Begin an attempt with the text of its case; `cause` says why it was made."""
        attempt = Attempt(len(self.made) + 1, text, cause)
        if self.made:
            attempt.changes = revising.change_lines(self.made[-1].text, text)
        self.made.append(attempt)
        return attempt

    def record_agreement(self, attempt: Attempt, agreement: Agreement) -> None:
        """Record the agreement of an attempt that is about to run, so that a later one can go back to it."""
        self._agreed[attempt.number] = copy(agreement)

    @property
    def timed(self) -> bool:
        """Whether a run was timed, so that estimates of its duration are no longer needed."""
        return any(one.pace for one in self.made)

    def patience(self) -> float:
        """Return the expected wall time [s] from which the next run is to be stopped once its speed is known."""
        left, slow = self.limits.minutes_left(), [one.state for one in self.made].count("timeout")
        if left is None:
            return inf
        later = slow >= len(FIRST_RUN_SHARES) or any(one.state == "finished" for one in self.made)
        return 60 * left * (LATER_RUN_SHARE if later else FIRST_RUN_SHARES[slow])

    def rows(self) -> str:
        """Return one line for each attempt."""
        return "\n".join(one.history_row() for one in self.made)

    def earlier(self, attempt: Attempt, agreement: Agreement) -> dict[int, tuple[str, Agreement]]:
        """Return the text and agreement of the attempts that can be changed instead of the latest, by number.

        Args:
            attempt: The latest attempt.
            agreement: The present agreement; that of an earlier attempt must have the same checks.
        """
        return {
            one.number: (one.text, copy(self._agreed[one.number]))
            for one in self.made
            if one is not attempt and one.number in self._agreed and self._agreed[one.number].same_checks(agreement)
        }

    def left(self) -> str:
        """Return a sentence with the attempts and time left; a resumed loop gets the same one again."""
        return self.time_left()[0]

    def time_left(self) -> tuple[str, float | None]:
        """Return the sentence of `left`, and the minutes that it names; None without a limit."""
        attempt = self.made[-1] if self.made else Attempt(0, "", "before the first")
        minutes = self.attempts.minutes_left(attempt, self.limits.minutes_left())
        words = [f"{self.limits.attempts - attempt.number} of {self.limits.attempts} attempts are left"]
        if minutes is not None:
            words.append(f"{minutes:.0f} minutes are left for everything")
        # The run of an attempt that was a trial before takes no time.
        longest = max(self.made[-RECENT_RUNS:], key=lambda one: one.took, default=attempt)
        if longest.took:
            took = f"attempt {longest.number} took {longest.took:.0f} s, with start, judging and pictures"
            words.append(f"{took}; it simulated a second in {longest.pace:.3g} s")
        return "; ".join(words) + ".", minutes
