"""Zarr's other readers and writers: when one of many fails, they go on, and somebody has to wait for them."""

from __future__ import annotations

import asyncio
from contextlib import suppress

#: Seconds after which a reader or writer is left to itself.
LONGEST = 10.0


def wait_for_zarr() -> None:
    """Wait until what Zarr has begun has ended; call it after a read or a write has failed.

    Zarr reads and writes chunks side by side and raises the first error at once. The others go on behind our back:
    they make files again in a folder that was just removed, and at the end of the process they complain one by one.
    """

    async def rest() -> None:
        others = asyncio.all_tasks() - {asyncio.current_task()}
        if others:
            done, _late = await asyncio.wait(others, timeout=LONGEST)
            for task in done:
                if not task.cancelled():
                    task.exception()  # seen: nobody need hear of it

    with suppress(Exception):  # another Zarr may do it in another way; there is nothing to lose
        from zarr.core.sync import sync

        sync(rest())
