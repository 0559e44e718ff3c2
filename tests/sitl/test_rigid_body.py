import math

import numpy as np
import pytest
from sitl_flights import BEBOP2

from sitl.arrays import Vec3
from sitl.rigid_body import Airframe, Body, advance, airframe, body_on_ground
from sitl.vehicle import GRAVITY_M_S2

STEP_S = 1e-3
STILL = np.zeros(3)
FRAME = airframe(BEBOP2)
NO_DRAG = FRAME._replace(linear_drag=np.zeros(3), quadratic_drag=np.zeros(3), rotor_drag=0.0)
HOVER_SPEED = BEBOP2.hover_speed_rad_s


def aloft(height: float = 100.0, rotor_speed: float = 0.0) -> Body:
    body = body_on_ground(4)
    body.motion[2] = -height
    body.rotor_speed[:] = rotor_speed
    return body


def run(
    frame: Airframe, body: Body, seconds: float, *, commands: float | Vec3 = 0.0, wind: Vec3 = STILL
) -> None:
    speeds = np.broadcast_to(np.asarray(commands, dtype=float), 4).copy()
    for _ in range(round(seconds / STEP_S)):
        advance(frame, body, speeds, wind, STEP_S)


def test_free_fall_is_exact() -> None:
    body = aloft()
    run(NO_DRAG, body, 2.0)
    assert body.motion[5] == pytest.approx(2.0 * GRAVITY_M_S2, rel=1e-9)
    assert body.motion[2] == pytest.approx(-100.0 + 2.0 * GRAVITY_M_S2, rel=1e-9)


def test_hover_speed_keeps_the_vehicle_where_it_is() -> None:
    body = aloft(rotor_speed=HOVER_SPEED)
    before = body.motion.copy()
    run(FRAME, body, 5.0, commands=HOVER_SPEED)
    assert body.motion == pytest.approx(before, abs=1e-6)


def test_torque_free_rotation_keeps_energy_momentum_and_norm() -> None:
    body = aloft(height=1e4)
    body.motion[10:13] = (8.0, 5.0, -6.0)

    def energy_and_momentum() -> tuple[float, float]:
        spin = FRAME.inertia * body.motion[10:13]
        return float(spin @ body.motion[10:13]), float(np.linalg.norm(spin))

    before = energy_and_momentum()
    run(NO_DRAG, body, 3.0)
    assert energy_and_momentum() == pytest.approx(before, rel=1e-6)
    assert np.linalg.norm(body.motion[6:10]) == pytest.approx(1.0, abs=1e-12)


def test_angular_drag_stops_a_rotation() -> None:
    frame = NO_DRAG._replace(angular_drag=np.array((0.004, 0.0, 0.0)))
    body = aloft(height=1e4)
    body.motion[10] = 2.0
    run(frame, body, 0.5)
    decay = math.exp(-0.5 * 0.004 / frame.inertia[0])
    assert body.motion[10] == pytest.approx(2.0 * decay, rel=1e-6)


def test_total_angular_momentum_includes_the_rotors() -> None:
    """Without friction in the air, spinning rotors up turns the body the other way."""
    frame = NO_DRAG._replace(moment_coefficient=0.0, spin=np.array((1.0, 1.0, 1.0, 1.0)))
    body = aloft(height=1e4)
    run(frame, body, 0.5, commands=500.0)
    rotors = -4.0 * frame.rotor_inertia * body.rotor_speed[0]  # counter-clockwise: against down
    assert frame.inertia[2] * body.motion[12] + rotors == pytest.approx(0.0, abs=1e-9)


def test_gyroscopic_torque_couples_roll_into_pitch() -> None:
    frame = NO_DRAG._replace(moment_coefficient=0.0, spin=np.array((-1.0, -1.0, -1.0, -1.0)))
    body = aloft(rotor_speed=HOVER_SPEED)
    body.motion[10] = 1.0
    run(frame, body, 0.01, commands=HOVER_SPEED)
    momentum = 4.0 * frame.rotor_inertia * HOVER_SPEED
    assert body.motion[11] == pytest.approx(0.01 * momentum / frame.inertia[1], rel=0.05)


def test_rotors_turn_the_body_as_their_places_say() -> None:
    def rates_after(stronger: tuple[int, int]) -> Vec3:
        commands = np.full(4, HOVER_SPEED)
        commands[list(stronger)] *= 1.01
        body = aloft(rotor_speed=HOVER_SPEED)
        run(FRAME, body, 0.1, commands=commands)
        return body.motion[10:13]

    front_right, rear_left, front_left, _ = range(4)
    assert rates_after((front_left, rear_left))[0] > 0.1  # roll right
    assert rates_after((front_left, front_right))[1] > 0.1  # pitch up
    assert rates_after((front_right, rear_left))[2] > 0.01  # the counter-clockwise pair yaws right


def test_motor_follows_with_its_time_constant() -> None:
    body = aloft()
    run(FRAME, body, FRAME.time_constant, commands=1000.0)
    lag = 1.0 - math.exp(-round(FRAME.time_constant / STEP_S) * STEP_S / FRAME.time_constant)
    assert body.rotor_speed == pytest.approx(1000.0 * lag)


def test_drag_opposes_the_velocity_through_the_air() -> None:
    body = aloft(rotor_speed=HOVER_SPEED)
    body.motion[3] = 3.0
    run(FRAME, body, 0.1, commands=HOVER_SPEED)
    assert 2.9 < body.motion[3] < 3.0
    blown = aloft(rotor_speed=HOVER_SPEED)
    run(FRAME, blown, 0.1, commands=HOVER_SPEED, wind=np.array((3.0, 0.0, 0.0)))
    assert blown.motion[3] == pytest.approx(3.0 - body.motion[3], rel=0.01)
    with_the_wind = aloft(rotor_speed=HOVER_SPEED)
    with_the_wind.motion[3] = 3.0
    run(FRAME, with_the_wind, 0.1, commands=HOVER_SPEED, wind=np.array((3.0, 0.0, 0.0)))
    assert with_the_wind.motion[3] == pytest.approx(3.0)


def test_rotor_drag_grows_with_the_rotor_speed() -> None:
    def slowed_by(speed: float) -> float:
        frame = NO_DRAG._replace(rotor_drag=1e-5)
        body = aloft(rotor_speed=speed)
        body.motion[4] = 5.0
        run(frame, body, 0.1, commands=speed)
        return 5.0 - float(body.motion[4])

    assert slowed_by(800.0) == pytest.approx(2.0 * slowed_by(400.0), rel=0.02)


def test_rests_on_the_ground_to_the_last_bit() -> None:
    body = body_on_ground(4)
    before = body.motion.copy()
    run(FRAME, body, 1.0, commands=0.9 * HOVER_SPEED, wind=np.array((8.0, -3.0, 0.5)))
    assert (body.motion == before).all()


def test_falls_onto_the_ground_without_bounce_and_levels() -> None:
    body = aloft(height=1.0)
    body.motion[3] = 1.0
    body.motion[6:8] = math.cos(0.2), math.sin(0.2)
    run(FRAME, body, 2.0)
    assert body.motion[2:6] == pytest.approx(0.0, abs=0.0)
    assert body.motion[6] == pytest.approx(1.0)


def test_lifts_off_when_thrust_exceeds_weight() -> None:
    body = body_on_ground(4)
    run(FRAME, body, 1.0, commands=1.05 * HOVER_SPEED)
    assert body.motion[2] < -0.2
