"""Ledger of what was ordered from Meshy for a case, beside the manifest: nothing is paid for twice."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from text2sim.assets.safe_write import FOLDER, digest, keep, only_me, place_in, read_kept
from text2sim.spec_schema.errors import AssetError

FILE = f"{FOLDER}/meshy_tasks.json"
Stage = Literal["preview", "refine"]


@dataclass
class MeshyTask:
    """One task, from before it is asked for to its end."""

    asked: int
    """When it was asked for [ms since 1970]: written down before, so that a lost answer can be looked for."""
    price: int
    """Credits that it is expected to cost."""
    id: str = ""
    """Its name at Meshy; empty as long as no answer came."""
    status: str = ""
    """The last that was heard of it."""
    credits: int | None = None
    """What it cost, once that was said."""

    @property
    def cost(self) -> int:
        """Credits to count for it."""
        return self.price if self.credits is None else self.credits

    @property
    def over(self) -> bool:
        """Whether it ended without a result, so that another has to be asked for."""
        return self.status in ("FAILED", "CANCELED", "EXPIRED")


@dataclass
class Order:
    """A wish, and the tasks for it."""

    prompt: str
    options: dict[str, Any] = field(default_factory=dict)
    tasks: dict[str, MeshyTask] = field(default_factory=dict)
    """By stage: `preview`, `refine`."""
    former: list[MeshyTask] = field(default_factory=list)
    """Those that came to nothing."""


class OrderLedger:
    """The orders of a case. Every change is on disk before the next request goes out."""

    def __init__(self, case: Path) -> None:
        self.case = case

    def order(self, prompt: str, options: dict[str, Any]) -> tuple[str, Order]:
        """Return the order of a wish and its key, as it was left, or a new one."""
        key = digest(json.dumps([prompt, options], sort_keys=True).encode())[:16]
        return key, self.read().get(key) or Order(prompt, options)

    def spent(self) -> int:
        """Return all credits that this case cost so far, those of open tasks included."""
        orders = self.read().values()
        return sum(task.cost for order in orders for task in (*order.tasks.values(), *order.former))

    def known(self) -> set[str]:
        """Return the names of all tasks."""
        orders = self.read().values()
        return {task.id for order in orders for task in (*order.tasks.values(), *order.former) if task.id}

    def write(self, key: str, order: Order) -> None:
        """Keep an order."""
        with only_me(self.case):
            orders = self.read() | {key: order}
            text = json.dumps({"version": 1, "orders": {k: asdict(o) for k, o in orders.items()}}, indent=1)
            keep(self.case, FILE, (text + "\n").encode())

    def read(self) -> dict[str, Order]:
        """Return all orders, by key.

        Raises:
            AssetError: if the file cannot be read: what was paid for would be lost.
        """
        if not place_in(self.case, FILE).exists():
            return {}
        try:
            data = json.loads(read_kept(self.case, FILE))
            return {str(key): _order(row) for key, row in data["orders"].items()}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            advice = "mend it, or remove it if nothing is paid for that you want to keep"
            raise AssetError(f"`{FILE}` is damaged; {advice}") from None


def _order(row: dict[str, Any]) -> Order:
    tasks = {str(stage): MeshyTask(**task) for stage, task in row["tasks"].items()}
    return Order(str(row["prompt"]), dict(row["options"]), tasks, [MeshyTask(**task) for task in row["former"]])
