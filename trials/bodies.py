"""Real questions to the server, and what may become of them on their way: seeded, so that every one can be repeated."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from random import Random
from typing import Any

ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1e308, -1e-308, float("nan"), float("inf"), float("-inf"), 10**400, 2**63, "", " ", "0",
    "1e999", "NaN", "\x00", "\ud800", "\u202e", "é" * 50, "😀", "9" * 5000, "<script>alert(1)</script>",
    "../../etc/passwd", "%00", "{{7*7}}", "__proto__", [], {}, [[]], [None], {"": None}, {"a": {"b": {"c": []}}},
    "x" * 100_000,
)  # fmt: skip
"""What stands in the place of a value."""

NAMES = ("", "a", "figure", "__class__", "constructor", "explore-answer", "{}", "..", "x" * 300, "\x00", "é")
"""What stands in the place of a name."""

MOST = 20_000
"""Places of a value that is changed once more: what is repeated again and again has millions."""

Place = tuple[Any, Any]
"""A list or a dictionary, and an index or a key of it."""


def places(value: Any) -> list[Place]:
    """All places in a value, from the outside inwards."""
    found: list[Place] = []
    waiting = deque([value])
    while waiting:
        part = waiting.popleft()
        keys = list(part) if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else []
        found += [(part, key) for key in keys]
        waiting += [part[key] for key in keys]
    return found


def _copy(value: Any) -> Any:
    return json.loads(json.dumps(value))


def _replace(random: Random, value: Any) -> None:
    part, key = random.choice(places(value))
    part[key] = random.choice(ODD)


def _remove(random: Random, value: Any) -> None:
    part, key = random.choice(places(value))
    del part[key]


def _repeat(random: Random, value: Any) -> None:
    part, key = random.choice(places(value))
    if isinstance(part, list):
        part.extend([part[key]] * random.choice((1, 2, 50)))
    else:
        part[f"{key}{random.choice(('', ' ', '2'))}"] = [part[key]] * random.choice((1, 2, 50))


def _rename(random: Random, value: Any) -> None:
    part, key = random.choice(places(value))
    if isinstance(part, dict):
        part[random.choice(NAMES)] = part.pop(key)
    else:
        part[key] = random.choice(NAMES)


def _swap(random: Random, value: Any) -> None:
    (one, here), (other, there) = random.choice(places(value)), random.choice(places(value))
    one[here], other[there] = _copy(other[there]), _copy(one[here])


def _deepen(random: Random, value: Any) -> None:
    part, key = random.choice(places(value))
    for _ in range(random.choice((1, 5, 60))):
        part[key] = [part[key]] if random.random() < 0.5 else {"a": part[key]}


def _near(random: Random, value: Any) -> None:
    """A value of the right type, somewhere else: what a hand might enter."""
    numbers = [(part, key) for part, key in places(value) if isinstance(part[key], int | float | str)]
    part, key = random.choice(numbers)
    if isinstance(part[key], str):
        part[key] += random.choice(("0", "e9", "-", ",1", " ", "x"))
    else:
        part[key] = part[key] * random.choice((-1, 0, 1e-9, 1e9)) + random.choice((0, 1, 0.5))


CHANGES: tuple[Callable[[Random, Any], None], ...] = (_replace, _remove, _repeat, _rename, _swap, _deepen, _near)


def changed(random: Random, value: Any) -> Any:
    """A value with one to four changes somewhere in it."""
    value = _copy(value)
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        if 0 < len(places(value)) < MOST:
            random.choice(CHANGES)(random, value)
    return value


def written(value: Any) -> bytes:
    """As JSON, with NaN and Infinity as they are, and halves of characters."""
    return json.dumps(value).encode()


def torn(random: Random, text: bytes) -> bytes:
    """Bytes that are no longer what they were: cut off, turned around, doubled, or others altogether."""
    at = random.randrange(len(text) + 1)
    return random.choice((
        text[:at],
        text[at:],
        text[:at] + bytes(random.randrange(256) for _ in range(random.choice((1, 8)))) + text[at:],
        text + text,
        b"[" * random.choice((10, 5_000, 100_000)) + text,
        text.replace(b":", b"=", 1),
        text.replace(b'"', b"'"),
        b'{"output":' * 500,
        b"\xef\xbb\xbf" + text,
        text.decode().encode("utf-16"),
        bytes(random.randrange(256) for _ in range(200)),
        b"",
        b"null",
        b"12",
    ))  # fmt: skip
