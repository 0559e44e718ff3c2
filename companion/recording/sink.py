"""What takes in a recording piece by piece: a file that is written, or the memory."""

from typing import Any, Protocol

from companion.recording.topics import Fields


class Sink(Protocol):
    """Takes in messages in the order in which things happened; none of its methods waits."""

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        """A message of `companion.recording.topics`; `time_s` is the recording's clock (s)."""
        ...

    def add_metadata(self, name: str, values: dict[str, Any]) -> None:
        """What is known once, as JSON can say it; a later one of the same name takes its place."""
        ...

    def attach(self, name: str, data: bytes) -> None:
        """Bytes that messages refer to by `name`; they come before those messages."""
        ...
