# SPDX-License-Identifier: Apache-2.0
"""Event loop of asyncio in a thread of its own, beside the loop of a node."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from concurrent.futures import Future
from typing import Any, TypeVar

_T = TypeVar("_T")


class EventLoopThread:
    """Runs coroutines while the calling thread does other work."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._posted: Future[object] | None = None
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()

    def call(self, coroutine: Coroutine[Any, Any, _T], seconds: float = 30.0) -> _T:
        """Run a coroutine and wait for its result, at most this long [s]; raises what it raises, or TimeoutError."""
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(seconds)

    def post(self, coroutine: Coroutine[Any, Any, object]) -> None:
        """Run a coroutine without waiting for it; its error is raised by the next call of this method."""
        if self._posted is not None and self._posted.done():
            self._posted.result()
        self._posted = asyncio.run_coroutine_threadsafe(coroutine, self._loop)

    def close(self) -> None:
        """Cancel what still runs, and end the thread."""
        self.call(_cancel_others())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


async def _cancel_others() -> None:
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
