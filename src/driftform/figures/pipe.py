"""The pipe of a study before any flight: in side view, and from above, with its parts, outlets, release and targets."""

from collections.abc import Sequence
from textwrap import wrap

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import start_page, write
from driftform.figures.plot import Window, draw_cross, draw_scene, label_points, pipe_ink, pipe_points
from driftform.figures.projection import PLAN, SIDE
from driftform.figures.style import INK, MUTED, SCREEN, WRONG, Page
from driftform.types import FloatArray
from driftform.water import Scenario

_LEFT, _RIGHT, _TALLEST = 62.0, 24.0, 420.0
_LINE, _LETTER = 18.0, 6.5


def pipe_svg(
    scenario: Scenario,
    title: str,
    wrong: Sequence[tuple[str, FloatArray]] = (),
    notes: Sequence[str] = (),
    page: Page = SCREEN,
) -> str:
    """Return the pipe as SVG, to scale, axes in metres: a side view, and a plan view of a pipe that is not straight.

    Points that are ``wrong`` (names and positions, m, (3,)) are marked, and ``notes`` on what is wrong are written below.
    """
    layout, top = scenario.pipe.layout, 92.0
    windows: list[Window] = []
    places = np.vstack([scenario.release_position()[None], scenario.target_array(), *(point for _, point in wrong)])
    for view in (SIDE,) if scenario.pipe.straight is not None else (SIDE, PLAN):
        shown = np.vstack([places, pipe_points(scenario.pipe)])
        windows.append(Window.around(view, shown, _LEFT, top, page.width - _LEFT - _RIGHT, _TALLEST, 26))
        top = windows[-1].box.bottom + 74
    names = ", ".join(placed.name for placed in layout.parts) or "open water"
    lines = [line for note in notes for line in wrap(note, int((page.width - _LEFT - _RIGHT) / _LETTER))]
    height = top - 10 + _LINE * len(lines)
    root = start_page(height, title, f"From the inlet on: {names}", f"The pipe of a study: {names}.", page)
    for number, line in enumerate(lines):
        write(root, _LEFT, top - 18 + _LINE * number, line, 12, WRONG)
    outlets = {} if scenario.pipe.straight is not None else {o.name: o.opening.centre for o in layout.outlets}
    for window in windows:
        write(root, _LEFT, window.box.top - 10, {SIDE: "Side view", PLAN: "From above"}[window.view], 12, MUTED)
        draw_scene(root, window, scenario)
        release, *targets = window.to_page(places)
        svg.add_circle(root, release[0], release[1], 4.5, "#ffffff", INK, 1.6)
        names_of = [*((name, INK, True) for name in scenario.target_names), *((name, WRONG, True) for name, _ in wrong)]
        for (x, y), (_, colour, _) in zip(targets, names_of, strict=True):
            draw_cross(root, x, y, 5.5, colour)
        labels = [("release", MUTED, False), *names_of]
        anchors = [release, *targets]
        for name, centre in outlets.items():
            if name not in scenario.target_names:
                anchors.append(window.to_page(centre[None])[0])
                labels.append((name, MUTED, False))
        label_points(root, window, np.array(anchors), labels, [pipe_ink(window, scenario.pipe)], keep=8)
    return svg.render(root)
