"""Sweeps as written in a case: lists and grids of changes."""

from typing import Annotated, Any

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Model, Name, exactly_one_of

MAX_RUNS = 200
"""Largest number of runs of a sweep."""


class Sweep(Model):
    """Several runs of one case: exactly one of these."""

    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] | None = Field(default=None, min_length=1, max_length=20)
    """Values by dotted path (`bodies.ball.material.density: [500, 1000]`); every combination is run."""
    points: dict[Name, dict[str, Any]] | None = Field(default=None, min_length=1)
    """Changes by name, each as in `variants`."""
    variants: list[Name] | None = Field(default=None, min_length=1)
    """Names of variants, one for each run."""

    _one_form = exactly_one_of("grid", "points", "variants")

    @model_validator(mode="after")
    def _small(self) -> "Sweep":
        if self.size > MAX_RUNS:
            raise ValueError(f"a sweep may have at most {MAX_RUNS} runs (got {self.size})")
        return self

    @property
    def size(self) -> int:
        """Number of runs."""
        size = len(self.points or self.variants or [0])
        for values in (self.grid or {}).values():
            size *= len(values)
        return size
