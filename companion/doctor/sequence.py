"""How many frames got lost, from the numbers on those that arrived."""

from companion.doctor.observation import Loss

_MODULUS = 256


class SequenceCount:
    """The sequence numbers of one component's frames, which count each frame that it sends on a link."""

    def __init__(self) -> None:
        self._newest: int | None = None
        self._missing: set[int] = set()
        self._frames = self._duplicated = self._reordered = 0

    def add(self, sequence: int) -> None:
        """A frame with that number (0 to 255) arrived."""
        if self._newest is None:
            self._newest = sequence
        ahead = (sequence - self._newest) % _MODULUS
        number = self._newest + (ahead if ahead < _MODULUS // 2 else ahead - _MODULUS)
        if number > self._newest:
            self._missing.update(range(self._newest + 1, number))
            self._newest = number
        elif number in self._missing:
            self._missing.discard(number)
            self._reordered += 1
        elif self._frames:
            self._duplicated += 1
            return
        self._frames += 1

    @property
    def loss(self) -> Loss:
        """What they tell so far."""
        return Loss(self._frames, len(self._missing), self._duplicated, self._reordered)
