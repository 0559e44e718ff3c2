"""Discrete linear systems: their home is `companion.similarity`, which compares them."""

from companion.similarity.linear_system import LinearSystem

__all__ = ["LinearSystem"]
