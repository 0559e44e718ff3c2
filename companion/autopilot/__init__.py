"""What differs between autopilots: modes, arming, taking over, refusals."""

from companion.autopilot.detect import Identity, detect, identify
from companion.autopilot.interface import Autopilot

__all__ = ["Autopilot", "Identity", "detect", "identify"]
