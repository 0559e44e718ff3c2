"""How hot the companion computer is, where Linux tells it."""

import asyncio
import math
import re
from pathlib import Path

_ZONES = Path("/sys/class/thermal")
_OF_PROCESSORS = re.compile(r"cpu|core|soc|pkg|k10temp|bcm|acpitz", re.IGNORECASE)
_LOOK_EVERY_S = 5.0
_MILLI = 1e-3


class Thermometer:
    """Keeps the newest temperature in `celsius`; NaN where none is known."""

    def __init__(self, zones: Path = _ZONES) -> None:
        self.celsius = math.nan
        self._zones = zones

    async def keep_reading(self) -> None:
        """Read now and then, until cancelled; in a thread, for some sensors take their time."""
        while True:
            self.celsius = await asyncio.to_thread(hottest_c, self._zones)
            await asyncio.sleep(_LOOK_EVERY_S)


def hottest_c(zones: Path = _ZONES) -> float:
    """Temperature of the hottest thermal zone of a processor (°C); NaN where Linux tells none.

    Source: https://docs.kernel.org/driver-api/thermal/sysfs-api.html
    """
    return max(filter(math.isfinite, map(_zone_c, zones.glob("thermal_zone*"))), default=math.nan)


def _zone_c(zone: Path) -> float:
    try:
        if not _OF_PROCESSORS.search((zone / "type").read_text(encoding="utf-8")):
            return math.nan
        return _MILLI * int((zone / "temp").read_text(encoding="utf-8"))
    except (OSError, ValueError):  # a zone that is switched off cannot be read
        return math.nan
