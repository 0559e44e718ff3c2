"""What the operating system says when a transport cannot be opened, in words that help."""

import errno
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from companion.errors import LinkError

_ADVICE = {
    errno.EADDRINUSE: "the port is taken: end the program that has it (see `ss -lnp`), or use another port",
    errno.EADDRNOTAVAIL: "this machine has no such address: listen on 0.0.0.0, or on an address of its own",
    errno.ECONNREFUSED: "nothing listens there: start the vehicle or the simulator first, and check the port",
    errno.EHOSTUNREACH: "no way to that host: check the address and the network",
    errno.ENETUNREACH: "no way to that network: check the address and the network",
    errno.EACCES: "permission denied: for a serial port join its group (`sudo adduser $USER dialout`) and "
    "log in again, for a network port use a number above 1023",
    errno.ENOENT: "there is no such device: check the cable and `ls /dev/tty*`",
    errno.EBUSY: "another program has it open: end that program first",
}


@contextmanager
def explained(what: str) -> Iterator[None]:
    """Turn an OSError of the block into a LinkError about `what` that says what to do."""
    try:
        yield
    except socket.gaierror as error:
        raise LinkError(f"{what}: the host is unknown ({error.strerror}): check the name") from error
    except TimeoutError as error:
        raise LinkError(f"{what}: no answer: check the address and the network") from error
    except OSError as error:
        advice = _ADVICE.get(error.errno or 0, str(error))
        raise LinkError(f"{what}: {advice}") from error
