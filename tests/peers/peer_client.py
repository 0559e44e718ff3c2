"""What a client of another maker is asked to do, in the same words for each."""

from collections.abc import Sequence
from typing import Protocol

Place = Sequence[float]
"""Latitude, longitude (degrees), and height above home (m)."""


class Client(Protocol):
    """A client with its connection to one vehicle.

    Each method does what it says with the client's own means and returns when the client holds it for done;
    what it reports is what the client knows. A client has only the methods that it has the means for.
    """

    def autopilot(self) -> str:
        """What the vehicle says it is: `px4` or `ardupilot`."""

    def system_id(self) -> int: ...

    def ready(self) -> bool:
        """Whether the client holds the vehicle for ready to arm."""

    def set_mode(self, name: str) -> None:
        """Ask for a flight mode, by the client's own name."""

    def mode(self) -> str:
        """The flight mode, by the client's own name."""

    def arm(self) -> None:
        """Arm, in a mode that can be armed in."""

    def disarm(self) -> None: ...

    def armed(self) -> bool: ...

    def take_off(self, height_m: float) -> None: ...

    def place(self) -> Place:
        """Where the vehicle is."""

    def go_to(self, place: Place) -> None: ...

    def stream_position(self, ned: Sequence[float]) -> None:
        """Begin to send a position (m from the local origin), and take control with it."""

    def stream_velocity(self, ned: Sequence[float]) -> None:
        """Begin to send a velocity (m/s), and take control with it."""

    def stop_stream(self) -> None:
        """Send no more setpoints, and leave the vehicle in a hold."""

    def return_home(self) -> None: ...

    def land(self) -> None: ...

    def texts(self) -> Sequence[str]:
        """The vehicle's status texts so far."""

    def parameters(self) -> dict[str, float]:
        """Every parameter."""

    def parameter(self, name: str) -> float: ...

    def set_parameter(self, name: str, value: float) -> None: ...

    def home(self) -> Place:
        """Latitude, longitude (degrees), altitude above sea (m)."""

    def upload(self, waypoints: Sequence[Place]) -> None:
        """Replace the mission."""

    def download(self) -> Sequence[Place]:
        """The waypoints of the vehicle's mission."""

    def start_mission(self) -> None: ...

    def items_done(self) -> int:
        """How many waypoints of the mission are behind the vehicle."""

    def clear_mission(self) -> None: ...

    def upload_file(self, path: str) -> None:
        """Replace the mission, and fence and rally points where there are any, by those of a file."""

    def upload_fence(self, corners: Sequence[Place]) -> None:
        """Replace the fence by a polygon to stay in."""

    def download_fence(self) -> Sequence[Place]: ...

    def clear_fence(self) -> None: ...

    def upload_rally_points(self, places: Sequence[Place]) -> None: ...

    def download_rally_points(self) -> Sequence[Place]: ...

    def logged(self) -> Sequence[str]:
        """The types of the messages in the client's own log of the link."""
