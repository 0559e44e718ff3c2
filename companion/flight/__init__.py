"""The tracking loop, its strategies, and the guard that may overrule every setpoint."""
