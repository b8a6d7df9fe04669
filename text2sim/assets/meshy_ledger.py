"""Ledger of Meshy tasks of a case, kept beside the manifest so that nothing is paid for twice."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from text2sim.assets.safe_write import FOLDER, digest, only_me, place_in, read_kept, write_asset
from text2sim.spec_schema.errors import AssetError

FILE = f"{FOLDER}/meshy_tasks.json"
Stage = Literal["preview", "refine"]


@dataclass
class MeshyTask:
    """A task of Meshy."""

    asked: int
    """Time of the request [ms since 1970], stored before it is sent so that a lost answer can be found."""
    price: int
    """Expected cost [credits]."""
    id: str = ""
    """Its id at Meshy; empty until the answer arrives."""
    status: str = ""
    """Its latest known status."""
    credits: int | None = None
    """Its cost; None until Meshy reports it."""

    @property
    def cost(self) -> int:
        """Its cost [credits], or the expected one until that is known."""
        return self.price if self.credits is None else self.credits

    @property
    def over(self) -> bool:
        """Whether it ended without a result."""
        return self.status in ("FAILED", "CANCELED", "EXPIRED")


@dataclass
class Order:
    """The tasks of a prompt with its options."""

    prompt: str
    options: dict[str, Any] = field(default_factory=dict)
    tasks: dict[str, MeshyTask] = field(default_factory=dict)
    """Tasks by stage: `preview`, `refine`."""
    former: list[MeshyTask] = field(default_factory=list)
    """Failed tasks."""


class OrderLedger:
    """The orders of a case. Every change is on disk before the next request is sent."""

    def __init__(self, case: Path) -> None:
        self.case = case

    def order(self, prompt: str, options: dict[str, Any]) -> tuple[str, Order]:
        """Return the key and the order of a prompt, which is new if there is none."""
        key = digest(json.dumps([prompt, options], sort_keys=True).encode())[:16]
        return key, self.read().get(key) or Order(prompt, options)

    def spent(self) -> int:
        """Return the credits that this case has cost so far, with those of open tasks."""
        return sum(task.cost for task in self._tasks())

    def known(self) -> set[str]:
        """Return the ids of all tasks."""
        return {task.id for task in self._tasks() if task.id}

    def _tasks(self) -> list[MeshyTask]:
        return [task for order in self.read().values() for task in (*order.tasks.values(), *order.former)]

    def write(self, key: str, order: Order) -> None:
        """Store an order."""
        with only_me(self.case):
            orders = self.read() | {key: order}
            text = json.dumps({"version": 1, "orders": {k: asdict(o) for k, o in orders.items()}}, indent=1)
            write_asset(self.case, FILE, (text + "\n").encode())

    def read(self) -> dict[str, Order]:
        """Return all orders, by key.

        Raises:
            AssetError: if the file is damaged; paid results would otherwise be lost.
        """
        if not place_in(self.case, FILE).exists():
            return {}
        try:
            data = json.loads(read_kept(self.case, FILE))
            return {str(key): _order(row) for key, row in data["orders"].items()}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            advice = "repair it, or remove it if it has no paid results that you want to keep"
            raise AssetError(f"`{FILE}` is damaged; {advice}") from None


def _order(row: dict[str, Any]) -> Order:
    tasks = {str(stage): _task(task) for stage, task in row["tasks"].items()}
    return Order(str(row["prompt"]), dict(row["options"]), tasks, [_task(task) for task in row["former"]])


def _task(row: dict[str, Any]) -> MeshyTask:
    task = MeshyTask(**row)
    numbers = task.asked, task.price, 0 if task.credits is None else task.credits
    if not all(type(number) is int for number in numbers) or not all(
        isinstance(w, str) for w in (task.id, task.status)
    ):
        raise TypeError("a task has a value of the wrong type")
    return task
