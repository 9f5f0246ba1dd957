"""Fenced blocks of the docs have words after their language, which tests read: the site shows ``file=`` as a title."""

import re

from markdown import Extension, Markdown
from markdown.preprocessors import Preprocessor

_START = re.compile(r"^```(\w+) (.+)$")
_FILE = re.compile(r"\bfile=(\S+)")


class _Words(Preprocessor):
    def run(self, lines: list[str]) -> list[str]:
        return [_START.sub(_titled, line) for line in lines]


def _titled(fence: re.Match[str]) -> str:
    file = _FILE.search(fence[2])
    return f"```{fence[1]}" + (f' title="{file[1]}"' if file else "")


class Fences(Extension):
    """Leaves of the words of a fence what the site can show."""

    def extendMarkdown(self, md: Markdown) -> None:  # noqa: N802 - named by Markdown
        """Go before the extension that reads fences."""
        md.preprocessors.register(_Words(md), "fence_words", 100)


def makeExtension(**_: object) -> Fences:  # noqa: N802 - named by Markdown
    """Return the extension."""
    return Fences()
