"""A live flight on ROS: steps in time with a clock, topics of each step, currents that arrive, services."""

import json
import math
import queue
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from driftform.errors import DriftformError, WorkFailedError, describe_error
from driftform_robotics.options import FlightOptions
from driftform_robotics.recording.messages import SECOND
from driftform_robotics.recording.topics import FlightTopics, Topic, Values, list_plumes, make_header
from driftform_ros.currents import Current

if TYPE_CHECKING:
    from driftform import Design
    from driftform_ros.rclpy_bus import RclpyBus
    from driftform_ros.rospy_bus import RospyBus

PATIENCE = 0.2
"""Longest wait before the loop looks whether ROS is still there, s."""

ANSWER_S = 10.0
"""Longest time until a released agent flies, s."""

SETTLE = 2.0
"""Time for waiting subscribers to find the topics, s."""

CURRENT = "geometry_msgs/TwistStamped"
"""Type of the messages that publish the current that acts."""

REHEARSAL = 1e-3
"""Steps before time begins, s."""

LATE = 1.0
"""Delay from which a warning is printed, s."""

SAME = 1e-9
"""Steps shorter than this are skipped, s."""


class LiveNode:
    """Flies one agent at a time.

    Args:
        open_other: opens an agent by its name or genome.
        options: namespace, sensors, and the time of the first release.
        interval: between two messages of a topic, in the time of the flight, s.
        rate: seconds of flight per second; 0 for no limit.
        max_current: fastest current that is taken, m/s.
    """

    def __init__(
        self,
        bus: "RospyBus | RclpyBus",
        open_other: Callable[[str], "Design"],
        options: FlightOptions,
        interval: float,
        rate: float,
        max_current: float,
    ) -> None:
        self._bus, self._open, self._options, self._interval = bus, open_other, options, interval
        self._rate, self._max_current = rate or math.inf, max_current
        self._requests: queue.Queue[Callable[[], None]] = queue.Queue()
        self._current: Current | None = None
        self._published = 0
        self._failure: WorkFailedError | None = None

    def run(self, design: "Design", once: bool) -> None:
        """Fly a design, then the agents that ``release`` asks for; with ``once`` return after the first flight.

        Raises WorkFailedError if ROS does not answer any more; with ``once`` also if the flight fails.
        """
        name = self._options.namespace
        self._rehearse(design)
        self._bus.check_clock()
        self._release(design, self._options.start)
        self._bus.receive_currents(self._options.world, self._receive_current)
        self._bus.serve(f"{name}/release", self._answer_release)
        self._bus.serve(f"{name}/evaluate", self._answer_evaluate)
        print(f"{design.name} flies at {self._bus.address}; topics in {name}/; end with Ctrl-C", flush=True)
        while self._bus.is_alive():
            if once and self._failure:
                raise self._failure
            if once and self._reason:
                return
            try:
                act = self._requests.get(timeout=min(PATIENCE, max(0.0, self._due - time.monotonic())))
            except queue.Empty:
                if time.monotonic() >= self._due:
                    self._tick()
                continue
            act()
        raise WorkFailedError(self._bus.lost)

    def _rehearse(self, design: "Design") -> None:
        """Fly two steps and make their messages: all is compiled, and all topics are known, when time begins."""
        flight = design.fly()
        flight.step(REHEARSAL)
        # A current across takes the flight out of its plane, which other kernels fly.
        flown = flight.step(REHEARSAL, np.add(design.scenario.current(), [0.0, 1e-3, 0.0]).tolist())
        self._bus.advertise(f"{self._options.namespace}/current", CURRENT, latched=True)
        for topic in self._list_topics(FlightTopics(design.export_job(), flown, self._options)):
            list(topic.messages())
            self._bus.advertise(topic.name, topic.kind, topic.latched)
        time.sleep(SETTLE)

    def _release(self, design: "Design", clock: float) -> None:
        """Release a design now, at a time of its own clock, s, or at that of ROS."""
        self._flight = design.fly()
        clock = clock if self._bus.has_clock else max(clock, self._bus.read_time())
        self._design, self._clock, self._ticks = design, clock, 0
        self._reason, self._failure, self._is_late = "", None, False
        # The wall time of the next messages, and how fast they follow each other.
        self._due = time.monotonic() + self._interval / self._rate
        self._live = self._options.model_copy(update={"start": clock})
        self._job, self._plumes = design.export_job(), list_plumes(design.scenario, self._live)
        self._pending = self._current
        self._publish(latched=True)
        self._publish()

    def _tick(self) -> None:
        late = time.monotonic() - self._due
        if math.isfinite(self._rate) and late > LATE and not self._is_late:
            self._is_late = True
            print(f"warning: the flight is {late:.1f} s late: it takes longer than its time", file=sys.stderr)
        self._ticks += 1
        if self._reason:
            # Between flights time passes as it does outside, if nothing limits that of a flight.
            self._due += self._interval / self._rate if math.isfinite(self._rate) else self._interval
            if self._bus.has_clock:
                now = round((self._clock + self._ticks * self._interval) * SECOND)
                self._send("/clock", "rosgraph_msgs/Clock", {"clock": divmod(now, SECOND)})
            return
        self._due += self._interval / self._rate
        self._fly(self._ticks * self._interval)
        self._publish()

    def _fly(self, until: float) -> None:
        """Continue the flight to a time since the release, s, in the last current received."""
        duration = until - self._flight.time
        if self._reason or duration <= SAME:
            return
        try:
            self._flight.step(duration, self._pending)
        except WorkFailedError as error:
            self._failure, self._reason = error, describe_error(error)
        else:
            self._reason = "" if self._flight.end is None else str(self._flight.end)
        self._pending = None
        if self._reason:
            again = self._bus.call.format(f"{self._options.namespace}/release")
            print(
                f"{self._design.name}: ends after {self._flight.time:.2f} s: {self._reason}; {again} flies again",
                flush=True,
            )

    def _receive_current(self, current: Current) -> None:
        at = time.monotonic()
        self._requests.put(lambda: self._meet_current(at, current))

    def _meet_current(self, at: float, current: Current) -> None:
        """Apply a current from its arrival; an equal one changes nothing."""
        if current == self._current:
            return
        if not (speed := math.hypot(*current)) <= self._max_current:
            print(
                f"warning: a current of {speed:.3g} m/s is refused: at most {self._max_current:g} m/s (--max-current)",
                file=sys.stderr,
            )
            return
        ahead = (self._due - at) * self._rate if math.isfinite(self._rate) else math.inf
        self._fly((self._ticks + 1) * self._interval - max(0.0, ahead))
        self._current = self._pending = current
        header = make_header(self._make_topics().stamps[0], self._options.world)
        self._send(f"{self._options.namespace}/current", CURRENT, {"header": header, "twist": {"linear": current}})

    def _send(self, topic: str, kind: str, values: Values) -> None:
        self._bus.publish(topic, self._bus.ros.encode(kind, values))

    def _make_topics(self) -> FlightTopics:
        """Return the topics of the last sample of the flight."""
        flown = self._flight.latest
        last = replace(
            flown, **{name: getattr(flown, name)[-1:] for name in ("t", "position", "quaternion", "velocity")}
        )
        if self._job.scenario is not self._flight.scenario:
            self._job = replace(self._job, scenario=self._flight.scenario)
        return FlightTopics(self._job, last, self._live, self._published, self._plumes)

    def _list_topics(self, topics: FlightTopics) -> list[Topic]:
        """Return the topics of a live flight: those of a recording, without the path, in the namespace of the node."""
        own = f"/{self._options.namespace}/"
        left_out = {f"{own}path", *(() if self._bus.has_clock else ("/clock",))}
        found = [topic for topic in topics.list_topics() if topic.name not in left_out]
        return [replace(t, name=t.name[1:]) if t.name.startswith(own) else t for t in found]

    def _publish(self, latched: bool = False) -> None:
        self._published += 1
        topics = self._make_topics()
        for topic in self._list_topics(topics):
            if topic.latched == latched:
                self._bus.advertise(topic.name, topic.kind, latched)
                for _, values in topic.messages():
                    self._send(topic.name, topic.kind, values)

    def _answer(self, design: "Design", done: Future[float]) -> None:
        """Release an agent, and tell when, s."""
        try:
            # The clock never goes back.
            self._release(design, self._clock + (self._ticks + 1) * self._interval)
        except DriftformError as error:
            done.set_exception(error)
        else:
            done.set_result(self._clock)

    def _open_named(self) -> "Design":
        """Open the agent that the parameter names, or return the one in flight."""
        text = self._bus.read_parameter(f"{self._options.namespace}/agent")
        return self._design if text is None else self._open(text)

    def _answer_release(self) -> tuple[bool, str]:
        try:
            design, done = self._open_named(), Future[float]()
            self._requests.put(lambda: self._answer(design, done))
            return True, f"{design.name} flies from {done.result(ANSWER_S):.3f} s"
        except (DriftformError, TimeoutError) as error:
            return False, describe_error(error)

    def _answer_evaluate(self) -> tuple[bool, str]:
        """Simulate the agent that the parameter names, without disturbing the live flight."""
        try:
            design = self._open_named()
            flight = design.simulate()
        except DriftformError as error:
            return False, describe_error(error)
        found = {
            "agent": design.name,
            "end": str(flight.end),
            "duration": flight.duration,
            "fitness": dict(flight.fitness),
            "closest": flight.closest,
        }
        return True, json.dumps(found)
