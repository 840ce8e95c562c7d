"""Streams of random numbers, one for each purpose.

    rng = stream(seed, "friction of the objects", label, finger)

numpy pads lists of seeds with zeros, so ``default_rng([3])`` and ``default_rng([3, 0])`` draw the
same numbers. Here purpose, seed and indices are hashed into 256 bits: two streams differ where any
of them does, and a list that is longer by a zero is another one.
"""

import hashlib

import numpy as np

_BITS = 53  # A seed of so many bits is exact in JSON.


def _entropy(seed: int, purpose: str, indices: tuple[int | str, ...]) -> int:
    plain = [each if isinstance(each, str) else int(each) for each in indices]
    text = repr((purpose, int(seed), *plain))
    return int.from_bytes(hashlib.sha256(text.encode()).digest())


def stream(seed: int, purpose: str, *indices: int | str) -> np.random.Generator:
    """Return the generator of one purpose; indices: which of its draws, such as a number."""
    return np.random.default_rng(_entropy(seed, purpose, indices))


def seed_for(seed: int, purpose: str, *indices: int | str) -> int:
    """Return a seed (53 bits) of one purpose, to hand on or to write down."""
    return _entropy(seed, purpose, indices) >> (256 - _BITS)
