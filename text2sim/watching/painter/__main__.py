"""The process that draws films while others simulate.

Every line of the standard input is an order, a number and the fields of `film.Order`, which ends the one before it, or
`{"cancel": 1}`; the end of the input ends the process. Every line of the standard output is news.
"""

import json
import os
import queue
import sys
import threading
from pathlib import Path
from typing import Any

from text2sim.watching.painter.context import NoOpenGL, open_context
from text2sim.watching.painter.film import Order, Studio, Superseded


class CommandLoop:
    """Takes orders and gives news."""

    def __init__(self) -> None:
        self._news = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)
        self.latest = 0
        """Number of the order that is wanted; 0 for none."""
        self.orders: queue.Queue[dict[str, Any] | None] = queue.Queue()
        threading.Thread(target=self._listen, name="orders", daemon=True).start()

    def tell(self, **news: Any) -> None:
        """Report something."""
        self._news.write(json.dumps(news) + "\n")
        self._news.flush()

    def tell_film(self, order: int, camera: str, path: Path, whole: bool) -> None:
        """Report a film."""
        self.tell(order=order, camera=camera, film=str(path), whole=whole)

    def _listen(self) -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "cancel" in order:
                self.latest = 0 if self.latest == order["cancel"] else self.latest
            else:
                self.latest = order["order"]
                self.orders.put(order)
        self.latest = 0
        self.orders.put(None)


def main() -> None:
    """Carry out orders until the input ends."""
    desk = CommandLoop()
    try:
        gl = open_context()
        studio = Studio(gl)
    except NoOpenGL as error:
        desk.tell(ready=False, message=str(error))
        return
    renderer = gl.glGetString(gl.GL_RENDERER)
    desk.tell(ready=True, renderer=renderer.decode("utf-8", "replace") if renderer else "")
    while (data := desk.orders.get()) is not None:
        number = data["order"]
        order = Order(data["script"], Path(data["out"]), data["width"], data["ahead"], data["colors"])
        try:
            frames = studio.film(
                order,
                lambda number=number: desk.latest == number,
                lambda *film, number=number: desk.tell_film(number, *film),
            )
            desk.tell(order=number, frames=frames)
        except Superseded:
            desk.tell(order=number, superseded=True)
        except Exception as error:
            import traceback

            traceback.print_exc()
            desk.tell(order=number, message=f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
