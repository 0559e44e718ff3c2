"""Bytes and text made wrong, in the ways in which links, disks, editors and enemies do it."""

import re
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

Mutation: TypeAlias = Callable[[bytes, np.random.Generator], bytes]

_LONGEST_PIECE = 64
_MOST_MUTATIONS = 4
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]\w*")
_NUMBERS = (
    *(b"0", b"-1", b"1e308", b"-1e308", b"1e-320", b"nan", b"NaN", b".inf", b"-Infinity", b"null", b"true"),
    *(
        b"2147483648",
        b"18446744073709551616",
        b"9" * 5000,
        b"0x7f",
        b"1_0",
        b"0b_",
        b"1:99:99",
        b"2001-99-99",
    ),
    *(b"", b"[]", b"{}", b'"', b"[" * 2000, b'{"a":' * 2000, b"\xff\xfe", "٣".encode(), b"1\x00", b"&a [*a]"),
)
"""What a number in a text is replaced by."""


def _flip(content: bytes, rng: np.random.Generator) -> bytes:
    place = _place(content, rng)
    return content[:place] + bytes([content[place] ^ 1 << int(rng.integers(8))]) + content[place + 1 :]


def _overwrite(content: bytes, rng: np.random.Generator) -> bytes:
    place, noise = _place(content, rng), _noise(rng)
    return content[:place] + noise + content[place + len(noise) :]


def _insert(content: bytes, rng: np.random.Generator) -> bytes:
    place = _place(content, rng)
    return content[:place] + _noise(rng) + content[place:]


def _delete(content: bytes, rng: np.random.Generator) -> bytes:
    place = _place(content, rng)
    return content[:place] + content[place + int(rng.integers(1, _LONGEST_PIECE)) :]


def _repeat(content: bytes, rng: np.random.Generator) -> bytes:
    start, end = sorted((_place(content, rng), _place(content, rng)))
    return content[:end] + content[start:]


def _cut(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: _place(content, rng)]


def _extreme(content: bytes, rng: np.random.Generator) -> bytes:
    place, width = _place(content, rng), int(rng.choice([1, 2, 4, 8]))
    return content[:place] + [b"\x00", b"\xff", b"\x7f"][rng.integers(3)] * width + content[place + width :]


def _other_number(content: bytes, rng: np.random.Generator) -> bytes:
    return _replaced(_NUMBER, content, _NUMBERS[rng.integers(len(_NUMBERS))], rng)


def _other_word(content: bytes, rng: np.random.Generator) -> bytes:
    words = _WORD.findall(content) or [b"x"]
    return _replaced(_WORD, content, words[rng.integers(len(words))], rng)


BYTES: tuple[Mutation, ...] = (_flip, _overwrite, _insert, _delete, _repeat, _cut, _extreme)
TEXT: tuple[Mutation, ...] = (*BYTES, *[_other_number, _other_word] * 4)


def mutated(content: bytes, mutations: Sequence[Mutation], rng: np.random.Generator) -> bytes:
    """`content` after one to four of the `mutations`."""
    for _ in range(int(rng.integers(1, _MOST_MUTATIONS + 1))):
        content = mutations[int(rng.integers(len(mutations)))](content or b"\0", rng)
    return content


def _place(content: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(content)))


def _noise(rng: np.random.Generator) -> bytes:
    return rng.bytes(int(rng.integers(1, _LONGEST_PIECE)))


def _replaced(pattern: re.Pattern[bytes], content: bytes, by: bytes, rng: np.random.Generator) -> bytes:
    """`content` with one match of the pattern, from a random place on, replaced."""
    found = pattern.search(content, _place(content, rng))
    return content if found is None else content[: found.start()] + by + content[found.end() :]
