"""One record schema for data sets and flight logs, and its files."""

from companion.recording.card import Card, read_card
from companion.recording.excerpt import cut
from companion.recording.files import read_recording
from companion.recording.mcap_file import write_recording
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.segments import Segment, Window
from companion.recording.series import (
    Provenance,
    Recording,
    ReferenceSeries,
    StateSeries,
    TrackingSeries,
    digest,
)

__all__ = [
    "Card",
    "Provenance",
    "Recording",
    "ReferenceSeries",
    "Segment",
    "StateSeries",
    "TrackingAccuracy",
    "TrackingSeries",
    "Window",
    "cut",
    "digest",
    "read_card",
    "read_recording",
    "tracking_accuracy",
    "write_recording",
]
