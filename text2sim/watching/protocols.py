"""Protocols of a session's partners: whoever reads the case, and whoever is told."""

from typing import TYPE_CHECKING, Any, Protocol

from text2sim.spec_schema.errors import Problem

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.loaded import LoadedCase
    from text2sim.watching.live_run import LiveRun


class Checked(Protocol):
    """A case that was read, as `text2sim check` reads it."""

    @property
    def loaded(self) -> "LoadedCase | None":
        """The case, if it could be read."""
        ...

    @property
    def plan(self) -> "Plan | None":
        """Its plan, if nothing keeps it from running."""
        ...

    @property
    def problems(self) -> list[Problem]:
        """What is wrong."""
        ...

    @property
    def sources(self) -> dict[str, str]:
        """Texts of the files that problems are about, by name."""
        ...

    @property
    def failure(self) -> str:
        """What is wrong, where no line of the case is to blame."""
        ...

    @property
    def ok(self) -> bool:
        """Whether nothing keeps it from running."""
        ...

    @property
    def name(self) -> str:
        """Name of the case."""
        ...


class Listener(Protocol):
    """Who is told what happens."""

    def checked(self, case: Checked, seconds: float) -> None:
        """A case was read, `seconds` after the save was noticed."""

    def status(self, words: str) -> None:
        """Something that takes long has begun or ended."""

    def trouble(self, words: str, problem: Problem | None) -> None:
        """Something went wrong; `problem` says at which line of the case, if that is known."""

    def done(self, take: "LiveRun", evidence: dict[str, Any] | None, no_scene: str) -> None:
        """States, judgement and scene are up to date; `no_scene` says why there is none.

        Args:
            take: The take.
            evidence: Its evidence; None if it could not be judged.
            no_scene: Why there is nothing to show; empty if there is something.
        """
