"""Errors of placement: what cannot be placed, and what cannot be reached."""


class PlaceError(ValueError):
    """A relation that cannot be fulfilled; `key` is the key of `place` to blame."""

    def __init__(self, message: str, key: str, rule: str = "placement", hint: str | None = None) -> None:
        super().__init__(message)
        self.key, self.rule, self.hint = key, rule, hint


class PatternError(ValueError):
    """A pattern that cannot be made; `where` is the path from its body to what is wrong."""

    def __init__(self, message: str, *where: str) -> None:
        super().__init__(message)
        self.where = where


class ReachError(ValueError):
    """Joints that cannot do what is asked; `where` is the path from their control to what is wrong."""

    def __init__(self, message: str, *where: str | int) -> None:
        super().__init__(message)
        self.where = where
