"""One record schema for data sets and flight logs, and its files."""

from companion.recording.mcap_file import McapWriter, read_recording, write_recording
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.series import (
    Provenance,
    Recording,
    ReferenceSeries,
    StateSeries,
    TrackingSeries,
    digest,
)

__all__ = [
    "McapWriter",
    "Provenance",
    "Recording",
    "ReferenceSeries",
    "StateSeries",
    "TrackingAccuracy",
    "TrackingSeries",
    "digest",
    "read_recording",
    "tracking_accuracy",
    "write_recording",
]
