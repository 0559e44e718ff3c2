"""A note on disk of a flight under way, which one that is cut off (`kill -9`, a power cut) leaves behind."""

import json
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from companion.flight.states import FlightState

_UNDER_WAY = (FlightState.TAKING_OFF, FlightState.APPROACHING)
_ENDED = (FlightState.HOLDING, FlightState.STANDBY)


class FlightNote:
    """The note of one vehicle's flights; there while a flight of ours is under way, or ended who knows how.

    Args:
        folder: where it lies.
        system_id: MAVLink id of the vehicle.
        flight: what to call the flight.
    """

    def __init__(self, folder: Path, system_id: int, flight: str) -> None:
        self._path = folder / f"in-flight-{system_id}.json"
        self._flight = flight
        self._is_ours = False
        self._disk = ThreadPoolExecutor(max_workers=1)

    def former(self) -> str:
        """What the flight was called that left the note; empty where there is none."""
        try:
            told = json.loads(self._path.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError):
            return ""
        except (OSError, ValueError):
            return "a flight"
        return str(told.get("flight", "a flight"))[:100] if isinstance(told, dict) else "a flight"

    def state(self, state: FlightState) -> Future[None]:
        """The flight came to another state; a disk that is slow or fails keeps nobody from flying.

        Returns:
            Done when the note says so; the program does not end before.
        """
        return self._disk.submit(self._write, state)

    def _write(self, state: FlightState) -> None:
        try:
            if state in _UNDER_WAY or (self._is_ours and state not in _ENDED):
                self._is_ours = True
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._path.write_text(json.dumps({"flight": self._flight, "state": state}), encoding="utf-8")
            elif self._is_ours:
                self._path.unlink(missing_ok=True)
        except OSError:
            return
