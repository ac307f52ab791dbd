"""What one visitor asks is done in order, one thing after the other; visitors do not wait so.

A question asked while a recording is still being read is about that recording, and of two that were
opened the one clicked last is shown. The toolkit orders all visitors' requests or none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def keep_session_order(queue: Any, line: str) -> None:
    """Have a toolkit's queue begin no request of a session that has one running already.

    Args:
        queue: The page's own.
        line: Name of the requests that this holds for (`concurrency_id`).
    """
    first_ready: Callable[[], Any] = queue.get_events

    def get_events() -> Any:
        waiting = queue.event_queue_per_concurrency_id.get(line)
        if waiting is None:
            return first_ready()
        running = {
            event.session_hash
            for job in queue.active_jobs
            for event in job or ()
            if event.concurrency_id == line
        }
        everyone = waiting.queue
        waiting.queue = [one for one in everyone if one.session_hash not in running]
        chosen = first_ready()
        begun = chosen[0] if chosen else ()
        waiting.queue = [one for one in everyone if one not in begun]
        return chosen

    queue.get_events = get_events
