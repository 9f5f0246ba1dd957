"""Plain bodies, and a secant for each target: what every search should beat."""

from driftform_strategies.tuned import Job, Shape, TunedStrategy

PLAIN = 30
"""Random shapes of which the plainest is taken."""


class DirectStrategy(TunedStrategy):
    """No evolution: a plain body, near to a cylinder, is tuned for each target, then another one.

    The body is that of some random ones whose wall is inclined least. It shows what is gained without a search for shapes.
    """

    name = "direct"

    def _start_job(self, target: int) -> Job:
        self._started[target] += 1
        shape = next((shape for shape in self._fresh if target not in shape.tried), None)
        if shape is None:
            found = [self._take_random(target) for _ in range(PLAIN)]
            shape = min(found, key=self._measure_incline)
            if shape not in self._fresh:
                self._fresh.append(shape)
        shape.tried.add(target)
        tuning = self._find_tuning(shape, target) if shape.points else None
        return Job(shape, target, shape.tune(self._guess_root(shape, target)) if tuning is None else tuning)

    def _measure_incline(self, shape: Shape) -> float:
        """Return the mean inclination of the wall of a shape, rad."""
        modules = self.space.grammar.express(shape.genome).modules
        length = sum(module.length for module in modules)
        return sum(abs(module.tilt) * module.length for module in modules) / max(length, 1e-9)
