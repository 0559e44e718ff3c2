"""The battery: charge drawn by the rotors, and the voltage that is left for them."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array
from sitl.compiled import compiled
from sitl.rigid_body import Airframe
from sitl.vehicle import Vehicle


class Pack(NamedTuple):
    """Constants of a battery, and its state.

    Attributes:
        state: remaining charge (0 to 1), voltage under load (V), current (A).
        sag: share of the voltage that is missing besides what charge and current take (0 to 1).
    """

    full_voltage: float
    empty_voltage: float
    charge: float
    resistance: float
    efficiency: float
    state: Float[Array, "3"]
    sag: Float[Array, "1"]


def full_pack(vehicle: Vehicle) -> Pack:
    """The vehicle's battery, full and unloaded."""
    battery = vehicle.battery
    return Pack(
        full_voltage=battery.full_voltage_v,
        empty_voltage=battery.empty_voltage_v,
        charge=vehicle.battery_charge_as,
        resistance=vehicle.battery_resistance_ohm,
        efficiency=battery.drive_efficiency,
        state=np.array((1.0, battery.full_voltage_v, 0.0)),
        sag=np.zeros(1),
    )


@compiled
def drain(pack: Pack, frame: Airframe, rotor_speed: Float[Array, " n"], dt: float) -> None:
    """Draw the rotors' shaft power for `dt` (s) at the voltage of the step before, in place."""
    shaft_power = 0.0
    for speed in rotor_speed:
        shaft_power += frame.moment_coefficient * speed**3
    current = shaft_power / pack.efficiency / pack.state[1]
    remaining = max(0.0, pack.state[0] - current * dt / pack.charge)
    open_circuit = pack.empty_voltage + remaining * (pack.full_voltage - pack.empty_voltage)
    pack.state[0] = remaining
    loaded = max(0.5 * pack.empty_voltage, open_circuit - current * pack.resistance)
    pack.state[1] = (1.0 - pack.sag[0]) * loaded
    pack.state[2] = current
