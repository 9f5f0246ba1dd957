"""Flights by driftform's integrator, optionally in parallel threads."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from driftform.interfaces import AccuracyOptions, Simulator, option
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Scenario


class NativeOptions(AccuracyOptions):
    """Options of the native backend."""

    threads: int = option(
        1,
        "flights of a batch that run in parallel; the worker processes of a run already share the machine",
        gt=0,
        le=1024,
    )


class NativeSimulator(Simulator[NativeOptions]):
    """DOP853 away from the wall and DOPRI5 near it, both adaptive; a second flight checks the error of each flight.

    A flight is one call of compiled code, which releases the interpreter lock: flights of a batch can run in threads.
    """

    name = "native"
    Options = NativeOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, at the horizon, or when it is no longer finite."""
        return self._fly(agent, scenario)

    def simulate_batch(self, agents: Sequence[Agent], scenarios: Sequence[Scenario]) -> list[Trajectory]:
        """Return the flights of many agents, each in its own scenario."""
        return self._map(self._fly, agents, scenarios)

    def screen_batch(
        self, agents: Sequence[Agent], scenarios: Sequence[Scenario], matters: Callable[[int, Trajectory], bool]
    ) -> list[Trajectory]:
        """Return the flights of many agents; of one that does not matter, the first of those that are compared."""

        def screen(index: int) -> Trajectory:
            return self._fly(agents[index], scenarios[index], lambda flight: matters(index, flight))

        return self._map(screen, range(len(agents)))

    def _map(self, fly: Callable[..., Trajectory], *arguments: Sequence[object]) -> list[Trajectory]:
        if self.options.threads == 1 or len(arguments[0]) < 2:
            return list(map(fly, *arguments))
        with ThreadPoolExecutor(self.options.threads) as pool:
            return list(pool.map(fly, *arguments))

    def _fly(self, agent: Agent, scenario: Scenario, matters: Callable[[Trajectory], bool] | None = None) -> Trajectory:
        # Imported here, because compiled code loads the compiler, and listing the plugins must not.
        from driftform.motion import forces, solver

        o = self.options
        accuracy = solver.Accuracy(o.accuracy, o.tolerance, o.tightest, o.max_step, o.step_limit)
        model = forces.flight_model(agent, scenario)
        start = forces.release_state(model, scenario)

        def fly(tolerance: float) -> FloatArray:
            return solver.integrate_once(model, start, scenario.flight.horizon, accuracy.tighten_to(tolerance))

        return solver.fly_checked(fly, model, scenario, accuracy, matters)
