"""Passages of prose, out of mark-up, manual pages, dictionaries and games, as a reader reads."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from html.parser import HTMLParser

from geotlm_lm.query.reader import cleaned_text

SHORTEST, LONGEST = 40, 600
"""Characters of a passage."""

_LETTERS = 0.88  # least share of letters and spaces; a table or code has fewer
_COMMON = 0.1  # least share of words that English is full of
_WORDS = (
    "a about all also an and any are as at be been but by can do for from had has have he her his "
    "how if in into is it its may more not of on one or other she so some such that the their them "
    "then there these they this to use was we what when where which who will with you your"
)
_FREQUENT = frozenset(_WORDS.split())
_REMAINS = re.compile(r"[][{}<>|\\_=~^#@$*`+]|https?:|www\.|::|\(\)|/\w+/|(^|\s)-\w|--\w|\.\w+/")
_PLAIN = str.maketrans("‘’“”–—−", "''\"\"---", "\u00ad\u200b")
_UNREAD = re.compile(
    r"[/._](ar|bg|ca|cs|da|de|el|es|eu|fa|fi|fr|gl|he|hr|hu|id|it|ja|ko|lt|lv|nb|nl|nn|no|pl|pt|ro"
    r"|ru|sk|sl|sr|sv|tr|uk|vi|zh)([-_@][\w@]+)?[/.]|(?i:changelog|copyright|licen[cs]e|legal|gfdl"
    r"|_sources|genindex|bookindex|/examples?/)"
)


def passages_of(text: str) -> Iterator[str]:
    """Yield the passages of a text whose paragraphs blank lines part, as the reader reads them.

    A heading that asks stays with what answers it; a long paragraph ends where a sentence does.
    """
    asked = ""
    for paragraph in re.split(r"\n\s*\n", text.translate(_PLAIN)):
        if re.search(r"\S {3,}\S", paragraph):  # columns
            continue
        plain = re.sub(r" +([,.;:?!)]+)(?= |$)", r"\1", cleaned_text(paragraph)).strip()
        plain = plain.lstrip("-,.;:) ")
        if plain.endswith("?") and len(plain) < 2 * SHORTEST and not asked:
            asked = f"{plain} "
            continue
        rest, asked = asked + plain, ""
        while rest:
            cut = len(rest)
            if cut > LONGEST:
                cut = 1 + max(rest.rfind(end, 0, LONGEST) for end in (". ", "? ", "! ", "; "))
            if is_english(rest[:cut]):
                yield rest[:cut]
            rest = rest[cut:].lstrip() if cut else ""
    if is_english(asked.strip()):
        yield asked.strip()


def is_english(passage: str) -> bool:
    """Tell whether a passage is English prose of a length, not code, mark-up or a table."""
    if not SHORTEST <= len(passage) <= LONGEST or not passage.isascii():
        return False
    words = re.findall(r"[a-z']+", passage)
    letters = sum(character.isalpha() or character == " " for character in passage)
    common = sum(word in _FREQUENT for word in words)
    is_prose = letters >= _LETTERS * len(passage) and common >= _COMMON * len(words)
    return is_prose and len(words) > 5 and _REMAINS.search(passage) is None


class _Page(HTMLParser):
    """Takes the paragraphs of HTML, DocBook or Mallard, without what is no prose."""

    skipped = re.compile(
        r"(head|script|style|pre|nav|header|footer|programlisting|screen|(cmd)?synopsis|math|svg"
        r"|select|button|table|legalnotice|bibliography)$"
    )
    breaks = re.compile(
        r"(p|br|div|li|d[ltd]|[uo]l|h\d|hr|body|blockquote|title|subtitle|desc|(sim|formal)?para"
        r"|listitem|item|term|section|sect\d|note|list|steps)$"
    )

    def __init__(self) -> None:
        super().__init__()
        self.depth = 0
        self.parts: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.depth += self.skipped.match(tag) is not None
        if self.breaks.match(tag):
            self.parts.append("\n\n")
        elif tag.startswith(("gui", "key")):
            self.parts.append(" ")

    def handle_endtag(self, tag: str) -> None:
        if self.depth and self.skipped.match(tag):
            self.depth -= 1
        if self.breaks.match(tag):
            self.parts.append("\n\n")

    def handle_data(self, data: str) -> None:
        if not self.depth:
            self.parts.append(re.sub(r"\s+", " ", data))


def _marked_up(text: str) -> str:
    page = _Page()
    page.feed(text)
    return "".join(page.parts)


def _glosses(text: str) -> str:
    """Return each meaning of WordNet as its words, what they mean, and examples."""
    entries = []
    for line in text.splitlines():
        fields, _, gloss = line.partition(" | ")
        names = fields.split()
        if gloss:
            words = names[4 : 4 + 2 * int(names[3], 16) : 2]
            plain = ", ".join(re.sub(r"\(\w+\)$", "", word) for word in words)
            entries.append(f"{plain.replace('_', ' ')}: {gloss}")
    return "\n\n".join(entries)


def _entries(text: str) -> str:
    """Return a dictionary's text without pronunciations, etymologies and names of sources."""
    text = re.sub(r"\[(1913 Webster|PJC|WordNet[^]]*)\].*$", "\n", text, flags=re.M)
    text = re.sub(r"\\[^\\\n]*\\|\([^()\n]*[?*`\"][^()\n]*\)|^\s*<[^>]*>", "", text, flags=re.M)
    for _ in range(2):  # brackets within brackets
        text = re.sub(r"\[[^][]*\]", "", text)
    text = re.sub(r"[{}]|--\s?[A-Z][^.\n]{0,30}(\.|$)(?=\s*\n)", "", text, flags=re.M)
    return re.sub(r"[ \t]+([,;.])", r"\1", text)


def _paragraphs(text: str) -> str:
    """Return a plain text, lines of signs alone taken for ends of paragraphs."""
    return re.sub(r"^\W+$", "\n", text, flags=re.M)


def _manual(text: str) -> str:
    """Return a manual page without the requests that set it."""
    is_set = r"^\.(nf|EX|Vb|TS|SY)\b.*?^\.(fi|EE|Ve|TE|YS)\b.*?$"
    text = re.sub(is_set, ".PP", text, flags=re.M | re.S)
    text = re.sub(
        r"^\.(B|I|BR|RB|IR|RI|BI|IB|SM|SB) (.*)$",
        lambda match: match[2].replace('"', ""),
        text,
        flags=re.M,
    )
    text = re.sub(r"^\.(PP|P|LP|TP|IP|SH|SS|RS|RE)\b.*$", "\n", text, flags=re.M)
    text = re.sub(r"^[.'].*\n", "", text, flags=re.M)
    text = re.sub(r"\\f(\(..|.)|\\[&|^%/,c]|\\s[-+]?\d|\\\*\(C['`]", "", text)
    text = re.sub(r"\\\*\([LR]\"", '"', text)
    return text.replace("\\-", "-").replace("\\(aq", "'").replace("\\ ", " ")


def _spoken(text: str) -> str:
    """Return what is told and said in a game."""
    matches = re.findall(r'_ *"((?:[^"]|"")*)"|`([^`\n]+)`', text)
    return "\n\n".join(quoted.replace('""', '"') or ticked for quoted, ticked in matches)


_READERS: tuple[tuple[str, Callable[[str], str]], ...] = (
    (r"/wordnet/data\.\w+$", _glosses),
    (r"/campaigns/.*\.cfg$|/endless-sky/data/.*\.txt$", _spoken),
    (r"\.dict\.dz$", _entries),
    (r"/fortunes/[\w-]+$|\.(txt|text)(\.gz)?$", _paragraphs),
    (r"\.(x?html?|docbook|page|xml)(\.gz)?$", _marked_up),
    (r"/man/man\d/[^/]+\.gz$", _manual),
)


def reader_of(name: str) -> Callable[[str], str] | None:
    """Return what takes the paragraphs out of such a file's text; none for one to leave unread."""
    if _UNREAD.search(name):
        return None
    return next((reader for pattern, reader in _READERS if re.search(pattern, name)), None)
