"""Flights in which something fails: what is done about it, and what that leads to."""
