"""What would stop a flight: one look at a vehicle and its link, and checks of what was seen.

`examine` looks, `judge` is a pure function of what it saw.
"""

from companion.doctor.checks import judge
from companion.doctor.examination import examine
from companion.doctor.finding import Finding, Severity
from companion.doctor.observation import Observation
from companion.doctor.traffic import Traffic

__all__ = ["Finding", "Observation", "Severity", "Traffic", "examine", "judge"]
