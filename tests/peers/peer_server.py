"""Serves a client's methods to the tests, which have a process, and perhaps an environment, of their own."""

import os
import sys
import threading
import time
from collections.abc import Callable
from xmlrpc.server import SimpleXMLRPCServer

PATIENCE_S = 25.0
_POLL_S = 0.02


def serve(client: object) -> None:
    """Answer calls on a free port, which it prints, until standard input closes."""
    with SimpleXMLRPCServer(("127.0.0.1", 0), allow_none=True, logRequests=False) as server:
        server.register_instance(client)
        print(f"serving at {server.server_address[1]}", flush=True)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        sys.stdin.read()
        os._exit(0)  # the clients' own threads need not agree


def wait_until(holds: Callable[[], object], what: str, patience_s: float = PATIENCE_S) -> None:
    """Return when something holds, or raise TimeoutError that says what did not."""
    give_up_s = time.monotonic() + patience_s
    while not holds():
        if time.monotonic() > give_up_s:
            raise TimeoutError(f"not within {patience_s:g} s: {what}")
        time.sleep(_POLL_S)
