"""Hostile input through the real readers: no crash, no hang, no growth, and no valid frame lost."""
