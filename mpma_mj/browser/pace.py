"""Pace of a simulation in real time."""

from __future__ import annotations

from collections import deque

__all__ = ["Pace"]

_LATEST = 0.2  # s of real time that are caught up at most (choice)
_RECENT = 2.0  # s over which the real-time factor is measured (choice)


class Pace:
    """Times at which steps are due; all times are real ones, s.

    Attributes:
        step_duration: Simulated time of a step, s.
        tempo: Simulated time over real time that is aimed at.
    """

    def __init__(self, step_duration: float) -> None:
        """Begin at tempo 1."""
        self.step_duration, self.tempo = step_duration, 1.0
        self._due = 0.0
        self._steps: deque[float] = deque()  # times of the steps of the last two seconds

    def start(self, now: float) -> None:
        """Begin after a pause: the next step is due now."""
        self._due = now
        self._steps.clear()

    def wait(self, now: float) -> float:
        """Return the time until the next step is due, 0 where it is."""
        return max(0.0, self._due - now)

    def step(self, now: float) -> None:
        """Receive that a step was done; the next is due a step later, less what is late."""
        self._due = max(self._due + self.step_duration / self.tempo, now - _LATEST)
        self._steps.append(now)
        while now - self._steps[0] > _RECENT:
            self._steps.popleft()

    @property
    def real_time_factor(self) -> float:
        """Simulated time over real time of the last two seconds; 0 before two steps."""
        if len(self._steps) < 2:
            return 0.0
        elapsed = self._steps[-1] - self._steps[0]
        return (len(self._steps) - 1) * self.step_duration / elapsed if elapsed else 0.0
