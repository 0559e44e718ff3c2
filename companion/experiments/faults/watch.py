"""What the autopilot of a simulated vehicle does and says, noted with its times."""

from dataclasses import dataclass, field

from sitl.firmware.interface import Landed, Mode, Severity
from sitl.mavlink import MavlinkVehicle


@dataclass(eq=False)
class Watch:
    """Looks at a vehicle again and again.

    Attributes:
        vehicle: behind its links.
        warnings: when it warned of what (s since boot).
        modes: when it entered which mode (s since boot).
    """

    vehicle: MavlinkVehicle
    warnings: list[tuple[float, str]] = field(default_factory=list)
    modes: list[tuple[float, Mode]] = field(default_factory=list)

    def look(self) -> None:
        """Note what is new."""
        simulation = self.vehicle.simulation
        now_s, mode = simulation.time_s, simulation.firmware.mode
        texts = self.vehicle.status_texts
        while texts:
            text = texts.popleft()
            if text.severity.value <= Severity.WARNING.value:
                self.warnings.append((now_s, text.text))
        if not self.modes or self.modes[-1][1] is not mode:
            self.modes.append((now_s, mode))

    @property
    def is_down(self) -> bool:
        """Whether the vehicle is on the ground and will stay there."""
        simulation = self.vehicle.simulation
        on_ground = float(simulation.truth.position[2]) >= 0.0
        return on_ground and (not simulation.firmware.armed or simulation.firmware.landed is Landed.ON_GROUND)
