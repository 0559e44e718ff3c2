"""The errors that the simulator raises on purpose.

SitlError
├── ConfigError    a vehicle, conditions or other file is missing or wrong
├── ParameterRefusedError    a parameter does not exist, or may not have that value
└── ServeError     the vehicle cannot be served: port in use, peer unknown
"""

from pathlib import Path


class SitlError(Exception):
    """The root: every error that the simulator raises on purpose."""


class ConfigError(SitlError):
    """A configuration file is missing or wrong.

    Attributes:
        file: the file as it was asked for.
        key: dotted path of the value, empty where the whole file is meant.
        reason: what was wrong, and what was expected.
    """

    def __init__(self, file: str | Path, key: str, reason: str) -> None:
        super().__init__(f"{file}: {key}: {reason}" if key else f"{file}: {reason}")
        self.file = str(file)
        self.key = key
        self.reason = reason


class ParameterRefusedError(SitlError):
    """A parameter does not exist, or may not have that value."""


class ServeError(SitlError):
    """The vehicle cannot be served over the network: a port is in use, or a peer's name is unknown."""
