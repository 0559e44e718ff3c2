import gc
import os
from unittest.mock import patch

import pytest

from companion.priority import Priority, prioritised

LINUX = hasattr(os, "sched_setscheduler")


def scheduling() -> tuple[int, ...]:
    policy = (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) if LINUX else ()
    return (*policy, os.getpriority(os.PRIO_PROCESS, 0), gc.get_freeze_count() > 0)


def test_priority_is_given_back() -> None:
    before = scheduling()
    with prioritised() as granted:
        assert granted in Priority
        assert gc.get_freeze_count() > 0
        assert (scheduling() == (*before[:-1], True)) == (granted is Priority.NORMAL)
    assert scheduling() == before


@pytest.mark.skipif(not LINUX, reason="only Linux has real-time scheduling for Python")
def test_who_may_not_have_real_time_gets_a_larger_share_or_the_usual_one() -> None:
    before = scheduling()
    with patch("os.sched_setscheduler", side_effect=PermissionError), patch("os.setpriority"):
        with prioritised() as granted:
            assert granted is Priority.HIGH
        with patch("os.setpriority", side_effect=PermissionError), prioritised() as granted:
            assert granted is Priority.NORMAL
    assert scheduling() == before
