"""How a flight makes its setpoints, in a form that a file can hold: enough to make them again."""

from pydantic import BaseModel, ConfigDict

from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT, OnlineSettings


class Technique(BaseModel):
    """What was chosen before the flight.

    Attributes:
        strategy: how the trajectory is tracked.
        online: settings of the online correction.
        lookahead_s: for the strategy that needs it (s).
        model: the inverse network, by name or file; None without one.
        model_sha256: of its file.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", protected_namespaces=())

    strategy: Strategy
    online: OnlineSettings = DEFAULT
    lookahead_s: float | None = None
    model: str | None = None
    model_sha256: str | None = None
