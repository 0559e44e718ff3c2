import asyncio
from collections.abc import Iterable

from fake_vehicle import in_virtual_time
from hypothesis import given
from hypothesis import strategies as st

from companion import clock
from companion.link.dialect import mavlink
from companion.link.status_text import StatusTexts, status_text

Message = mavlink.MAVLink_statustext_message
LONG = "Preflight Fail: " + "compass inconsistent with the gyro, " * 3
CRITICAL, INFO = mavlink.MAV_SEVERITY_CRITICAL, mavlink.MAV_SEVERITY_INFO


def said(severity: int, text: str, text_id: int = 0, place: int = 0) -> Message:
    return Message(severity, text.encode(), text_id, place)


def chunks(text: str, text_id: int = 9) -> list[Message]:
    starts = range(0, len(text) + 1, 50)
    return [said(CRITICAL, text[at : at + 50], text_id, place) for place, at in enumerate(starts)]


def heard(messages: Iterable[Message]) -> list[str]:
    """What is said at once when these messages come."""

    async def scenario() -> list[str]:
        texts, lines = StatusTexts(), list[str]()
        texts.subscribe(lambda line: lines.append(line.text))
        for message in messages:
            texts.add(message)
        return lines

    return clock.run(scenario(), virtual=True)


def test_a_text_is_joined_from_its_chunks() -> None:
    assert heard([*chunks(LONG), said(INFO, "Takeoff detected")]) == [LONG, "Takeoff detected"]
    assert heard(chunks("x" * 100)) == ["x" * 100]


@given(st.permutations(chunks(LONG) + chunks("a" * 70, 10) + chunks(LONG)))
def test_chunks_may_come_in_any_order_and_twice(messages: list[Message]) -> None:
    assert sorted(heard(messages)) == sorted([LONG, "a" * 70])


def test_a_line_that_comes_twice_at_once_is_said_once() -> None:
    line, other = said(INFO, "Takeoff detected"), said(CRITICAL, "Takeoff detected")
    assert heard([line, line, other]) == ["Takeoff detected"] * 2


@in_virtual_time
async def test_a_line_that_comes_again_later_is_said_again() -> None:
    texts = StatusTexts()
    for _ in range(3):
        texts.add(said(INFO, "Low battery"))
        await asyncio.sleep(1.0)
    assert [line.text for line in texts] == ["Low battery"] * 3


@in_virtual_time
async def test_lost_chunks_show_once_the_others_are_old() -> None:
    texts = StatusTexts()
    first, middle, last = chunks("a" * 50 + "b" * 50 + "c", 1)
    texts.add(last)
    texts.finish_old()
    assert list(texts) == []
    await asyncio.sleep(1.5)
    texts.finish_old()
    for chunk in (first, last):
        await asyncio.sleep(1.5)
        texts.add(said(CRITICAL, chunk.text, 2, chunk.chunk_seq))
    texts.add(said(CRITICAL, middle.text, 3, 0))
    assert texts.warnings_since(0.0) == ["…c", "a" * 50 + "…c", "b" * 50 + "…"]


@in_virtual_time
async def test_what_is_unfinished_does_not_pile_up() -> None:
    texts = StatusTexts()
    for text_id in range(1, 1000):
        texts.add(said(INFO, f"{text_id}".ljust(50), text_id, 0))
    assert len(list(texts)) == 200


@in_virtual_time
async def test_warnings_are_those_since_a_time_and_no_information() -> None:
    texts = StatusTexts()
    texts.add(said(CRITICAL, "old"))
    await asyncio.sleep(1.0)
    now_s = clock.now()
    texts.add(said(CRITICAL, "Arming denied"))
    texts.add(said(INFO, "hello"))
    assert texts.warnings_since(now_s) == ["Arming denied"]


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126), min_size=1, max_size=220))
def test_what_we_say_is_heard_as_it_was_said(text: str) -> None:
    messages = status_text(INFO, text)
    assert all(len(message.text) <= 50 for message in messages)
    assert heard(messages) == [text]
