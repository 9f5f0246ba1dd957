import pytest

from driftform.testing import RendererContract
from driftform_exudyn.film import ExudynRenderer, FilmOptions

pytestmark = pytest.mark.peers


class TestBothViews(RendererContract):
    rate, size = 10.0, (160, 100)

    def plugin(self):
        return ExudynRenderer(FilmOptions(width=160, height=100, fps=5, speed=0.5, rays=1))


class TestTheViewFromTheSide(RendererContract):
    rate, size = 10.0, (160, 90)

    def plugin(self):
        return ExudynRenderer(FilmOptions(width=160, height=90, fps=20, speed=2.0, view="side", rays=1))
