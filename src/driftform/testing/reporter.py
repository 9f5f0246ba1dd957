"""Contract of reporters."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

from driftform.interfaces import Flown, Reporter, ReportJob
from driftform.plugins.seams import require
from driftform.testing.agents import Spheroid
from driftform.testing.contract import SeamContract
from driftform.testing.inspector import SCENARIO
from driftform.testing.renderer import drifting_trajectory
from driftform.water import Scenario

_VOID = {"area", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}
"""Elements of HTML that have no end."""


class _Elements(HTMLParser):
    """Follows the elements of a fragment: those that are open, and what it would load or run."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take the start of an element."""
        if tag not in _VOID:
            self.open.append(tag)
        if tag in ("script", "iframe", "link"):
            self.loads.append(tag)
        for name, value in attrs:
            # A link that a reader may follow is not loaded.
            loaded = name in ("src", "srcset", "data") or (name.endswith("href") and tag != "a")
            if loaded and not (value or "").startswith(("#", "data:")):
                self.loads.append(f"{tag} {name}={value}")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take an element without content."""
        self.handle_starttag(tag, attrs)
        if tag not in _VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        """Take the end of an element."""
        assert self.open and self.open[-1] == tag, f"</{tag}> ends <{(self.open or ['nothing'])[-1]}>"
        self.open.pop()


class ReporterContract(SeamContract[Reporter[Any]]):
    """The contract of reporters."""

    def report_job(self, name: str = "run") -> ReportJob:
        """Return the run: one target, and a spheroid that drifts."""
        flown = Flown(f"{name}-leak", Spheroid(0.06, 0.01).agent(), drifting_trajectory(), 99.5)
        return ReportJob(name, SCENARIO, {"leak": flown})

    def write(self, job: ReportJob) -> str:
        """Return the section of a run."""
        reporter = self.plugin()
        return require(reporter.write(job), str, reporter, "write")

    def test_the_heading_is_one_line(self) -> None:
        """``heading`` is a title in one line."""
        heading = self.plugin().heading
        assert heading and heading.isprintable()

    def test_the_section_is_a_fragment_that_closes_what_it_opens(self) -> None:
        """Every element that is opened is closed, and the fragment has neither a head nor a body."""
        text = self.write(self.report_job())
        elements = _Elements()
        elements.feed(text)
        assert elements.open == []
        assert not re.search(r"<(html|head|body)\b", text)

    def test_the_section_needs_nothing_else(self) -> None:
        """It has no script, and loads nothing: no network, no other file."""
        elements = _Elements()
        elements.feed(self.write(self.report_job()))
        assert elements.loads == []

    def test_names_are_escaped(self) -> None:
        """Names of runs, targets and agents come from files: what looks like an element must not become one."""
        job = self.report_job("<b>run")
        job = replace(job, best={"<b>leak": replace(job.best["leak"], name="<b>agent")})
        assert "<b>run" not in self.write(job) and "<b>leak" not in self.write(job)
        assert "<b>agent" not in self.write(job)

    def test_a_run_in_open_water_without_agents_is_reported_too(self) -> None:
        """A scenario may have no pipe, and no target may have an agent."""
        self.write(replace(self.report_job(), scenario=Scenario(), best={}))

    def test_the_same_run_gives_the_same_section(self) -> None:
        """The text is the same the second time, and from a reporter that was sent to another process."""
        job = self.report_job()
        assert self.write(job) == self.write(job) == self.copy().write(job)
