"""What has ended and is still there."""

import contextlib
import gc
from types import CoroutineType

from tests.waiting import eventually


def there(names):
    """Which of these there are, by the names of their types, and coroutines by their own."""
    # Some things do not like to be asked for anything but their type.
    found = (thing.__qualname__ if type(thing) is CoroutineType else type(thing).__name__ for thing in gc.get_objects())
    return {name for name in found if name in names}


@contextlib.asynccontextmanager
async def without_the_collector(names):
    """While the collector is off: what comes into being has to go by itself, soon after the end."""

    def none_is_there():
        gc.collect()
        return not there(names)

    await eventually(none_is_there)
    gc.disable()
    try:
        yield
        await eventually(lambda: not there(names))
    finally:
        gc.enable()
