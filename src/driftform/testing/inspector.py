"""Contract of inspectors."""

import json
from typing import Any

from driftform.interfaces import Inspector
from driftform.plugins.seams import require_facts
from driftform.testing.agents import Spheroid, sphere_agent, straight_pipe
from driftform.testing.contract import SeamContract
from driftform.types import Agent
from driftform.water import Scenario

SCENARIO = Scenario(pipe=straight_pipe(9.0, 1.0), targets={"leak": (4.0, 0.0, -0.9)})
"""A straight pipe with a target."""


class InspectorContract(SeamContract[Inspector[Any]]):
    """The contract of inspectors."""

    def describe(self, agent: Agent, scenario: Scenario = SCENARIO) -> dict[str, Any]:
        """Return the facts of an agent."""
        inspector = self.plugin()
        return require_facts(inspector.describe(agent, scenario), inspector)

    def test_the_heading_is_one_line(self) -> None:
        """``heading`` is a title in one line."""
        heading = self.plugin().heading
        assert heading and heading.isprintable()

    def test_facts_are_numbers_and_texts_that_json_can_hold(self) -> None:
        """The facts of a spheroid and of a sphere are numbers, texts and lists of them, by their names."""
        for agent in (Spheroid(0.06, 0.01).agent(), sphere_agent(0.05, 0.5)):
            json.dumps(self.describe(agent))

    def test_an_agent_in_open_water_is_described_too(self) -> None:
        """A scenario may have neither a pipe nor targets."""
        self.describe(Spheroid(0.06, 0.01).agent(), Scenario())

    def test_the_same_agent_has_the_same_facts(self) -> None:
        """The facts are the same the second time, and from an inspector that was sent to another process."""
        agent = Spheroid(0.06, 0.01).agent()
        assert self.describe(agent) == self.describe(agent) == self.copy().describe(agent, SCENARIO)
