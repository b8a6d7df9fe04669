"""Protocols of a session's partners: a checked case, and a listener."""

from typing import TYPE_CHECKING, Any, Protocol

from text2sim.spec_schema.errors import Problem

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.loaded import LoadedCase
    from text2sim.watching.live_run import LiveRun


class Checked(Protocol):
    """A case as `text2sim check` reads it."""

    loaded: "LoadedCase | None"
    """The case, if it could be read."""
    plan: "Plan | None"
    """Its plan, if it can be run."""
    problems: list[Problem]
    sources: dict[str, str]
    """Texts of the files with problems, by name."""
    failure: str
    """Error message without a line of the case; empty if there is none."""

    @property
    def ok(self) -> bool:
        """Whether it can be run."""
        ...

    @property
    def name(self) -> str:
        """Name of the case."""
        ...


class Listener(Protocol):
    """Receiver of a session's events."""

    def checked(self, case: Checked, seconds: float) -> None:
        """A case was read, `seconds` after the save."""

    def status(self, words: str) -> None:
        """A slow step has begun or ended."""

    def trouble(self, words: str, problem: Problem | None) -> None:
        """An error occurred, at the line of the case in `problem` if that is known."""

    def done(self, live_run: "LiveRun", evidence: dict[str, Any] | None, no_scene: str) -> None:
        """States, evidence and scene are up to date.

        Args:
            live_run: The simulation.
            evidence: Its evidence; None if it could not be judged.
            no_scene: Why there is no scene; empty if there is one.
        """
