import pytest

from companion.link.address import parse_address
from companion.link.exposure import warning


@pytest.mark.parametrize("url", ["udpin://0.0.0.0:14540", "tcpin://192.168.1.7:5760", "udpin://[::]:14540"])
def test_who_listens_to_other_machines_unsigned_is_warned(url: str) -> None:
    told = warning([parse_address("udpout://10.0.0.1:14550"), parse_address(url)], signed=False)
    assert told is not None
    assert "--signing-key" in told
    assert warning([parse_address(url)], signed=True) is None


@pytest.mark.parametrize(
    "url",
    [
        *(
            "udpin://127.0.0.1:14540",
            "udpin://localhost:14540",
            "tcpin://[::1]:5760",
            "udpout://10.0.0.1:14550",
        ),
        *("tcpout://10.0.0.1:5760", "serial:///dev/ttyAMA0:921600", "sitl://bebop2"),
    ],
)
def test_who_listens_to_this_machine_or_none_is_not(url: str) -> None:
    assert warning([parse_address(url)], signed=False) is None
