"""Results that are kept in memory, by what they depend on."""

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

Result = TypeVar("Result")


class Memory(dict[Hashable, Result]):
    """A limited number of results by key; the oldest is forgotten first.

    `functools.lru_cache` serves where the arguments of the function are the key.

    Args:
        size: How many results are kept.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self.size = size

    def recall(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """Return the result of a key, which `make` computes if it is not known."""
        found = self.get(key)
        if found is None:
            found = self[key] = make()
            if len(self) > self.size:
                del self[next(iter(self))]
        return found


class ObjectKey:
    """A key that is equal for the same object alone, which it keeps, so that no other object gets its id."""

    __slots__ = ("value",)

    def __init__(self, of: Any) -> None:
        self.value = of

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ObjectKey) and other.value is self.value

    def __hash__(self) -> int:
        return id(self.value)
