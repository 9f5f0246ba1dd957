"""Pages of HTML that are complete in themselves: to read, and to print on A4."""

from html import escape

STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; max-width: 820px; margin: 1.5em auto; padding: 0 1em; color: #1f2a36 }
h1 { font-size: 1.5em; margin: 0 } h2 { font-size: 1.1em; margin: 1.2em 0 .3em }
table { border-collapse: collapse; margin: .5em 0 } th, td { padding: .2em .9em .2em 0; text-align: left }
th { border-bottom: 1px solid #586673 } .drops { display: flex; flex-wrap: wrap; gap: 2% }
.drops svg { width: 32%; height: auto }
.blank { border-bottom: 1px solid #586673; min-width: 6em; display: inline-block }
svg { max-width: 100% } .ruler svg { max-width: none } code { background: #f1f7fb }
@page { size: A4; margin: 10mm }
@media print { body { margin: 0; padding: 0; font-size: 10px; line-height: 1.3 } h2 { margin: .5em 0 .1em }
  .drops svg { width: 25% } .agent svg { max-height: 32mm } }
"""


def make_page(title: str, content: str) -> str:
    """Return a page with a heading; ``content`` is HTML."""
    heading = escape(title)
    return (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{heading}</title><style>{STYLE}</style>"
        f"<h1>{heading}</h1>{content}</html>\n"
    )
