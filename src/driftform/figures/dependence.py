"""What a miss depends on: a bar per disturbed quantity."""

from collections.abc import Sequence

from driftform.figures import svg
from driftform.figures.layout import write, write_title
from driftform.figures.style import MUTED, SCREEN, Page
from driftform.runs.misses import REST, Effect

WIDTH, MARGIN, TOP, ROW = 380.0, 12.0, 52.0, 24.0
"""Narrow enough for the screen of a telephone, px."""

LEFT, RIGHT = 160.0, 62.0


def dependence_svg(effects: Sequence[Effect], title: str, page: Page = SCREEN) -> str:
    """Return the effects as SVG: a bar as long as each standard deviation, with its value in mm."""
    width = page.width if page.is_paper else WIDTH
    height = TOP + ROW * len(effects) + MARGIN
    longest = max((effect.deviation for effect in effects), default=0.0)
    rows = "; ".join(f"{effect.name}: {_format_length(effect.deviation)}" for effect in effects)
    root = svg.start_document(width, height, title, f"What the miss depends on. {rows}.", page=page, header=26)
    if not page.is_paper:
        write_title(root, MARGIN, 22, title, 14, width - 2 * MARGIN)
    write(root, MARGIN, 40, "standard deviation of the closest approach by each cause", 11, MUTED)
    px_per_m = (width - LEFT - RIGHT) / (longest or 1.0)
    drawn = {"effects": effects, "rest": REST, "top": TOP, "row": ROW, "format_length": _format_length}
    svg.draw_template(root, __package__, "dependence", **drawn, left=LEFT, px_per_m=px_per_m)
    return svg.render(root)


def _format_length(metres: float) -> str:
    return f"{1000 * metres:.0f} mm" if metres >= 0.01 else f"{1000 * metres:.1f} mm"
