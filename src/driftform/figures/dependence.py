"""What a miss depends on: a bar for each disturbed quantity."""

from collections.abc import Sequence

from driftform.figures import svg
from driftform.figures.layout import shorten, write
from driftform.figures.style import BLUE, INK, MUTED, tint
from driftform.runs.dependence import REST, Effect

WIDTH, MARGIN, TOP, ROW = 380.0, 12.0, 52.0, 24.0
"""Narrow enough for the screen of a telephone, px."""

LEFT, RIGHT = 160.0, 62.0


def dependence_svg(effects: Sequence[Effect], title: str) -> str:
    """Return the effects as SVG: a bar as long as each standard deviation, with its value in mm."""
    height = TOP + ROW * len(effects) + MARGIN
    longest = max((effect.deviation for effect in effects), default=0.0)
    rows = "; ".join(f"{effect.name}: {_format_length(effect.deviation)}" for effect in effects)
    root = svg.start_document(WIDTH, height, title, f"What the miss depends on. {rows}.")
    write(root, MARGIN, 22, shorten(title, 14, WIDTH - 2 * MARGIN, bold=True), 14, bold=True)
    write(root, MARGIN, 40, "standard deviation of the closest approach by each cause", 11, MUTED)
    for number, effect in enumerate(effects):
        y = TOP + ROW * (number + 0.5)
        share = effect.deviation / longest if longest else 0.0
        write(root, LEFT - 10, y + 4, effect.name, 12, INK, "end")
        svg.add(
            root,
            "rect",
            class_="effect",
            x=LEFT,
            y=y - 8,
            width=max(1.0, share * (WIDTH - LEFT - RIGHT)),
            height=16,
            fill=tint(BLUE, 0.25) if effect.name == REST else tint(BLUE, 0.75),
        )
        x = LEFT + share * (WIDTH - LEFT - RIGHT) + 6
        write(root, x, y + 4, _format_length(effect.deviation), 12, INK)
    return svg.render(root)


def _format_length(metres: float) -> str:
    return f"{1000 * metres:.0f} mm" if metres >= 0.01 else f"{1000 * metres:.1f} mm"
