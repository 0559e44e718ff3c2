import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.link.address import Address, Serial, Simulated, TcpIn, TcpOut, UdpIn, UdpOut, parse_address


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udpin://0.0.0.0:14540", UdpIn("0.0.0.0", 14540)),
        (" udpin://0.0.0.0:14540\n", UdpIn("0.0.0.0", 14540)),
        ("udpout://192.168.1.10:14550", UdpOut("192.168.1.10", 14550)),
        ("udpout://[::1]:14550", UdpOut("::1", 14550)),
        ("tcpout://drone.local:5760", TcpOut("drone.local", 5760)),
        ("tcpin://0.0.0.0:5760", TcpIn("0.0.0.0", 5760)),
        ("serial:///dev/ttyAMA0:921600", Serial("/dev/ttyAMA0", 921600)),
        ("serial://COM3:57600", Serial("COM3", 57600)),
        ("sitl://bebop2", Simulated("bebop2")),
        ("sitl://bebop2?conditions=realistic&seed=1", Simulated("bebop2", "realistic", 1)),
        ("sitl:///home/me/my vehicle.yaml?seed=3", Simulated("/home/me/my vehicle.yaml", seed=3)),
        ("sitl://./vehicle.yaml?conditions=./wind.yaml", Simulated("./vehicle.yaml", "./wind.yaml")),
        (
            "sitl://iris?fault=motor_dead:motor=2,at_s=9&seed=4&fault=reboot",
            Simulated("iris", seed=4, faults=("motor_dead:motor=2,at_s=9", "reboot")),
        ),
    ],
)
def test_right_strings(text: str, address: Address) -> None:
    assert parse_address(text) == address


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("", "does not say how"),
        ("14540", "does not say how"),
        ("udp://:14540", "udpin:// to listen"),
        ("udp:127.0.0.1:14550", "udpin:// to listen"),
        ("udpin:0.0.0.0:14550", "two slashes are missing"),
        ("tcp:127.0.0.1:5760", "tcpout:// to connect"),
        ("udpin://0.0.0.0", "port is missing"),
        ("udpin://:14540", "host is missing"),
        ("udpin://0.0.0.0:0", "port is missing"),
        ("udpin://0.0.0.0:99999", "1 to 65535"),
        ("udpin://0.0.0.0:abc", "1 to 65535"),
        ("udpout://me@host:1", "nothing belongs"),
        ("udpout://host:1/path", "nothing belongs"),
        ("/dev/ttyUSB0", "serial:///dev/ttyAMA0:921600"),
        ("serial:///dev/ttyUSB0", "baud rate is missing"),
        ("serial:///dev/ttyUSB0:fast", "'fast' is not a number"),
        ("sitl://", "vehicle is missing"),
        ("sitl://bebop2?sed=1", "'sed' is no setting"),
        ("sitl://bebop2?seed=one", "'one' is not a whole number"),
        ("sitl://bebop2?realistic", "conditions=NAME"),
        ("http://host:80", "'http' is no way"),
    ],
)
def test_wrong_strings_say_what_is_right(text: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_address(text)
    assert hint in str(caught.value)
    assert "udpin://0.0.0.0:14540" in str(caught.value)
    assert "\n" not in str(caught.value)


@given(st.text(max_size=40) | st.text(max_size=30).map(lambda rest: f"udpin://{rest}"))
def test_any_text_is_an_address_or_an_input_error(text: str) -> None:
    said: Address | InputError
    try:
        said = parse_address(text)
    except InputError as error:
        said = error
    assert isinstance(said, Address) or "udpin://0.0.0.0:14540" in str(said)
