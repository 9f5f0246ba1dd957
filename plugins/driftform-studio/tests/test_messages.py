"""The words of the page: all of them are in one catalogue, in both languages."""

import json
import re
from html.parser import HTMLParser
from importlib.resources import files
from typing import get_args

import pytest

from driftform.water.parts.tee_store import PACKAGED
from driftform_frusta.cores import BallastOptions

PAGE = files("driftform_studio").joinpath("page")
SCRIPTS = {file.name: file.read_text(encoding="utf-8") for file in PAGE.iterdir() if file.name.endswith(".js")}
CATALOGUE = json.loads(SCRIPTS.pop("catalogue.js").partition("export default ")[2].rstrip().rstrip(";"))
ENGLISH, GERMAN = CATALOGUE["en"], CATALOGUE["de"]
DOCUMENT = PAGE.joinpath("index.html").read_text(encoding="utf-8")
SOURCES = "\n".join([DOCUMENT, *SCRIPTS.values()])

NOT_SAID = r"(?:class|className|keys|style|cap|class:|type|viewBox|dataset\.\w+) ?[:=] ?$|querySelector\w*\($|matches\($|closest\($|ctor\($|classList\.\w+\($|setAttribute\($|split\($|toggle\w*\($"
"""What stands before a string that nobody reads."""

NAMES = r"Prusa MK4S|Bambu Lab .*|Creality .*|Arrow\w+|Enter|Delete|Backspace|Home|Own|Other|M|[\w-]+/[\w-]+|.*driftform .*|.*--out parts|#.*|None|kept if weighed|writing the best agents|\(prefers-.*|userSpaceOnUse"
"""Names of printers, keys and programs, and what the server calls a state: the same in any language."""


def list_strings(script):
    """Yield the strings of a script that a reader might see, without the values in them."""
    script = re.sub(r"^\s*//[^\n]*$|(?<=[;{,)] )// [^\n]*$|/\*.*?\*/", "", script, flags=re.M | re.S)
    for match in re.finditer(r'"((?:[^"\\\n]|\\.)*)"|`((?:[^`\\]|\\.)*)`', script):
        if not re.search(NOT_SAID, script[: match.start()][-40:]):
            yield re.sub(r"\$\{[^}]*\}?", " ", match[1] if match[1] is not None else match[2])


def test_both_languages_say_everything_with_the_same_values():
    assert list(ENGLISH) == list(GERMAN)
    values = {key: [set(re.findall(r"\{(\w+)\}", words[key])) for words in (ENGLISH, GERMAN)] for key in ENGLISH}
    assert [key for key, (english, german) in values.items() if english != german] == []
    assert [key for key in ENGLISH if ENGLISH[key].count("|") != GERMAN[key].count("|")] == []
    # A message that is the same in both is a name, a number, or a word of both languages.
    same = [ENGLISH[key] for key in ENGLISH if ENGLISH[key] == GERMAN[key]]
    assert [text for text in same if len(re.sub(r"\{\w+\}", "", text).replace(", ", "").split()) > 3] == []


def test_every_message_that_the_page_asks_for_exists_and_none_is_left_over():
    asked = set(re.findall(r'(?:\b(?:speak|weave|say)\(|data-say(?:-\w+)?=)"([a-z][\w.-]*)"', SOURCES))
    assert sorted(asked - set(ENGLISH)) == [] and len(asked) > 200
    put_together = re.findall(r'(?:speak\(`|listMessages\(")([\w.]+\.)', SOURCES)
    written = re.findall(r'["`]([\w.\[\]-]+)["`]', SOURCES)
    assert [key for key in ENGLISH if key not in written and not key.startswith(tuple(put_together))] == []


def test_no_text_is_left_in_the_document():
    found = []

    class Texts(HTMLParser):
        def handle_data(self, data):
            found.extend(re.findall(r"[A-Za-z]{2,}", data))

        def handle_starttag(self, tag, attributes):
            found.extend(v for k, v in attributes if k in ("title", "alt", "aria-label", "placeholder") and v)

    Texts().feed(DOCUMENT)
    assert set(found) <= {"driftform", "studio"}


@pytest.mark.parametrize("name", sorted(SCRIPTS))
def test_no_text_is_left_in_a_script(name):
    said = [
        text for text in list_strings(SCRIPTS[name]) if re.search(r"\b[A-Z][a-z]{2}|[a-z]{2,}[,.;:]? [a-z]{2,}", text)
    ]
    classes = set(re.findall(r"\.([a-z]\w*)", PAGE.joinpath("studio.css").read_text(encoding="utf-8")))
    said = [
        text
        for text in said
        if not all(word in classes or "." in word[1:-1] or word == "pipe" for word in text.split())
    ]
    assert [text for text in said if not re.fullmatch(NAMES, text.strip())] == []


def test_pictures_have_no_words_and_the_ballast_is_what_the_builder_knows():
    pictures = [file for file in PAGE.iterdir() if file.name.endswith(".svg")]
    assert pictures and not any("<text" in file.read_text(encoding="utf-8") for file in pictures)
    known = get_args(BallastOptions.model_fields["material"].annotation)
    assert {key.removeprefix("ballast.") for key in ENGLISH if key.startswith("ballast.")} == set(known)


def test_walls_are_as_rough_as_moody_states_and_the_solved_junctions_are_those_that_come_with_driftform():
    [text] = re.findall(r"const WALLS = \{(.*?)\};", SCRIPTS["fields.js"])
    walls = {name: float(size) for name, size in re.findall(r"(\w+): ([\d.e-]+)", text)}
    feet = {"smooth": 5e-6, "steel": 1.5e-4, "coated": 4e-4, "iron": 8.5e-4, "cement": 1e-3, "concrete": 1e-2}
    assert {name: walls[name] for name in feet} == pytest.approx({k: 0.3048 * v for k, v in feet.items()}, rel=0.03)
    assert list(walls) == [key.removeprefix("wall.of.") for key in ENGLISH if key.startswith("wall.of.")]
    solved = sorted([float(v) for v in file.name.split("-")[1:3]] for file in PACKAGED.glob("tee-*"))
    assert sorted(json.loads(SCRIPTS["expect.js"].partition("SOLVED = ")[2].partition(";")[0])) == solved
