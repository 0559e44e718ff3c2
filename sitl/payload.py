"""A load that is fixed to the vehicle: other mass, other inertia, another centre of mass."""

import numpy as np

from sitl.conditions import Conditions, PayloadConditions
from sitl.errors import ConfigError
from sitl.rigid_body import Airframe, airframe
from sitl.vehicle import Vehicle

_MAX_HOVER_THRUST = 0.95
"""Share of the full thrust: a vehicle that needs more cannot be steered."""


def with_payload(frame: Airframe, payload: PayloadConditions) -> Airframe:
    """The vehicle with a point mass fixed to it (parallel axis theorem; products of inertia are left out).

    Positions are from the common centre of mass. It is what simulation and estimate call the vehicle's place
    before and after; the centimetre between both is no motion.
    """
    mass = frame.mass + payload.mass_fraction * frame.mass
    arm = np.hypot(frame.position[:, 0], frame.position[:, 1]).mean()
    place = arm * np.array(payload.place_arms)
    share = payload.mass_fraction / (1.0 + payload.mass_fraction)
    x, y, z = place**2
    return frame._replace(
        mass=mass,
        inertia=frame.inertia + share * frame.mass * np.array((y + z, x + z, x + y)),
        position=frame.position - share * place,
    )


def laden(vehicle: Vehicle, conditions: Conditions) -> Airframe:
    """The vehicle with the payload of these conditions, if they have one.

    Raises:
        ConfigError: it cannot carry it.
    """
    payload = conditions.payload
    if payload is None:
        return airframe(vehicle)
    hover_thrust = vehicle.hover_thrust * (1.0 + payload.mass_fraction)
    if hover_thrust > _MAX_HOVER_THRUST:
        raise ConfigError(
            conditions.name,
            "payload.mass_fraction",
            f"{vehicle.name} would hover at {hover_thrust:.0%} of its full thrust with that, "
            f"more than {_MAX_HOVER_THRUST:.0%}",
        )
    return with_payload(airframe(vehicle), payload)
