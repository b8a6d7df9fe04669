"""Requests to stop: Ctrl-C, SIGTERM and a closed terminal, counted while a program runs."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType
from typing import Any

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Stop:
    """Counts requests to stop while there is something to end gently; otherwise they interrupt as usual.

    A `with` block takes over the signals. Outside the main thread, where Python allows no handlers, only calls of
    `request` count.
    """

    def __init__(self) -> None:
        self.count = 0
        """Requests so far: the first asks a program to stop, the second kills it."""
        self._gentle = False
        self._before: dict[signal.Signals, Any] = {}

    def request(self) -> None:
        """Ask to stop."""
        self.count += 1

    @contextmanager
    def gently(self) -> Iterator[None]:
        """While this lasts, a signal is counted instead of raising KeyboardInterrupt."""
        self._gentle = True
        try:
            yield
        finally:
            self._gentle = False

    def __enter__(self) -> "Stop":
        if current_thread() is main_thread():
            for number in SIGNALS:
                # Signals that a shell made us ignore (`nohup`, background jobs) stay ignored.
                if signal.getsignal(number) is not signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._signalled)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        self.request()
        if not self._gentle:
            raise KeyboardInterrupt
