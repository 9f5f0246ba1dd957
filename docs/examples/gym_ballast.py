"""An environment of Gymnasium: a drifter of random shape chooses its ballast, flight by flight, until it hits its target."""

from dataclasses import replace

import gymnasium as gym
import numpy as np

import driftform as df


class BallastEnv(gym.Env):
    """An action is the ballast, from the least to the most that the shape can have; a flight's reward is its miss, -m."""

    observation_space = gym.spaces.Box(-100.0, 100.0, (3,), np.float64)
    action_space = gym.spaces.Box(-1.0, 1.0, (1,), np.float64)

    def __init__(self, target="TP6"):
        study = df.load_study("pipe-inspection", ["gusts.strength=0"], targets=[target], run={"seed": 1})
        self.pipeline, self.point = study.make_pipeline(), study.scenario.target_array()[0]

    def reset(self, *, seed=None, options=None):
        """Draw a shape; the observation is by how much it passes the target with ballast in the middle, m."""
        super().reset(seed=seed)
        self.flights, self.tunings = 0, None
        while self.tunings is None:
            self.genome = self.pipeline.grammar.random(self.np_random)
            self.tunings = self.pipeline.builder.find_tunings(self.pipeline.express(self.genome))
        return self.step(np.zeros(1))[0], {}

    def step(self, action):
        """Fly once with a ballast."""
        low, high = self.tunings
        tuning = low + (high - low) * (float(np.clip(action[0], -1, 1)) + 1) / 2
        [found] = self.pipeline.evaluate([replace(self.genome, tuning=tuning)])
        path, self.flights = found.trajectory.position - self.point, self.flights + 1
        offset = path[np.argmin(np.linalg.norm(path, axis=1))]
        miss = float(np.linalg.norm(offset))
        return offset, -miss, miss < 0.01, self.flights > 12, {}


if __name__ == "__main__":
    env = BallastEnv()
    offset, _ = env.reset(seed=8)
    low, high = -1.0, 1.0
    for _ in range(12):
        # Heavier bodies pass lower.
        middle = (low + high) / 2
        offset, reward, done, *_ = env.step(np.array([middle]))
        low, high = (middle, high) if offset[2] > 0 else (low, middle)
        if done:
            break
    print(f"misses by {-1000 * reward:.0f} mm after {env.flights} flights")
