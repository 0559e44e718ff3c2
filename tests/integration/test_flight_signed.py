"""A flight over a signed link on which somebody else forges and replays."""

from collections import Counter
from typing import Any

import numpy as np

from companion import clock
from companion.autopilot import detect
from companion.flight.approach import rest_to_rest
from companion.flight.flight import FlightPlan, fly
from companion.link import start_telemetry
from companion.link.address import Simulated
from companion.link.connection import connect_over
from companion.link.dialect import mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.signing import Rejection, Signer, SigningKey
from companion.link.simulated import SimulatedTransport, open_simulated
from companion.link.transport import Receiver
from companion.recording import Provenance

KEY, OTHER_KEY = SigningKey(bytes(range(32))), SigningKey(bytes(32))
FAR_FUTURE = 2**47


class SignedLink:
    """A `Transport` to the built-in vehicle on which pymavlink signs for the vehicle and checks for it.

    Between the vehicle's frames come the same once more, unsigned ones, and forged ones of the far future.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self.refused = 0
        self._here, self._forger = self._peer(KEY), self._peer(OTHER_KEY)
        self._forger.signing.timestamp = FAR_FUTURE
        self._unsigned = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    async def open(self, receiver: Receiver) -> "SignedLink":
        self._receiver = receiver
        self._transport: SimulatedTransport = open_simulated(Simulated("bebop2", seed=1), self)
        self.firmware = self._transport.vehicle.simulation.firmware
        return self

    def send(self, data: bytes) -> None:
        try:
            self._here.decode(bytearray(data))
        except mavlink.MAVError:
            self.refused += 1
        else:
            self._transport.send(data)

    def answer_sender(self) -> None: ...

    async def aclose(self) -> None:
        await self._transport.aclose()

    def bytes_received(self, data: bytes) -> None:
        for frame in FrameSplitter().feed(data):
            message = decode(frame)
            signed = message.pack(self._here)
            self._receiver.bytes_received(signed)
            self._receiver.bytes_received(signed)
            moved: Any = decode(frame)
            if isinstance(moved, mavlink.MAVLink_local_position_ned_message):
                moved.x += 100.0
            self._receiver.bytes_received(moved.pack(self._forger))
            self._receiver.bytes_received(moved.pack(self._unsigned))

    def transport_lost(self, error: Exception) -> None:
        self._receiver.transport_lost(error)

    @staticmethod
    def _peer(key: SigningKey) -> mavlink.MAVLink:
        peer = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        peer.signing.secret_key = key.secret
        peer.signing.sign_outgoing = True
        peer.signing.timestamp = 1000
        return peer


def test_a_signed_flight_is_flown_whatever_others_say() -> None:
    link = SignedLink()
    signer = Signer(KEY, lambda: 2000)
    start, end = np.array([0.0, 0.0, -2.0]), np.array([2.0, 0.0, -2.5])

    async def scenario() -> float:
        async with connect_over(link.open, signer=signer) as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            plan = FlightPlan(rest_to_rest(start, end, "straight"))
            outcome = await fly(plan, autopilot, telemetry, provenance=Provenance(vehicle="bebop2"))
            return outcome.accuracy.rms_m

    assert clock.run(scenario(), virtual=True) < 0.3
    assert link.refused == 0
    rejected: Counter[Rejection] = signer.rejected
    assert rejected.keys() == {Rejection.REPLAYED, Rejection.WRONGLY_SIGNED, Rejection.UNSIGNED}
    assert min(rejected.values()) > 1000
    assert signer.timestamp < FAR_FUTURE
