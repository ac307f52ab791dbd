"""Inflected verbs of motion, by what they mean: turning, sliding, any motion, pressing."""

from __future__ import annotations

from typing import Literal

Form = Literal["base", "third", "past", "gerund"]
Verb = tuple[str, str, str, str]

TURN = r"(?:turn|rotat|twist|spin|spun|swivel|pivot|revolv)"
SLIDE = r"(?:slid|slip|drag|glid|skid|translat)"
GO = r"(?:mov|travel|shift|creep|drift)"
STIR = r"(?:budg|stirr?)"
WOBBLE = r"(?:wiggl|jiggl|wobbl)"
"""Stems, of which any ending may follow; "go", "come" and "head" begin other words as well."""

ENDING = r"(?:e|es|s|ed|ing|ped|ping|ning|ged|ging|ded|ding|led|ling|red|ring)?"
"""What follows a stem of a verb, and of no noun."""


def _verbs(table: str) -> tuple[Verb, ...]:
    return tuple(tuple(line.split()) for line in table.strip().splitlines())


TURNS = _verbs("""
turn turns turned turning
rotate rotates rotated rotating
twist twists twisted twisting
spin spins spun spinning
pivot pivots pivoted pivoting
swivel swivels swiveled swiveling
swivel swivels swivelled swivelling
revolve revolves revolved revolving
""")
SLIDES = _verbs("""
slide slides slid sliding
slip slips slipped slipping
drag drags dragged dragging
glide glides glided gliding
skid skids skidded skidding
translate translates translated translating
""")
GOES = _verbs("""
go goes went going
move moves moved moving
travel travels traveled traveling
travel travels travelled travelling
shift shifts shifted shifting
head heads headed heading
creep creeps crept creeping
drift drifts drifted drifting
""")
MOVES = tuple(verb for verb in GOES if verb[0] != "head")
"""What goes, but for "heading", which asks which way."""

NEARS = _verbs("""
press presses pressed pressing
push pushes pushed pushing
indent indents indented indenting
sink sinks sank sinking
approach approaches approached approaching
""")
LIFTS = _verbs("""
lift lifts lifted lifting
detach detaches detached detaching
recede recedes receded receding
release releases released releasing
""")
PRESSES = (*NEARS, *LIFTS, ("pull", "pulls", "pulled", "pulling"))
RESTS = _verbs("""
rest rests rested resting
touch touches touched touching
""")
VERBS = TURNS + SLIDES + GOES + PRESSES + RESTS

_FORMS: tuple[Form, ...] = ("base", "third", "past", "gerund")
_BASES = {form: verb[0] for verb in VERBS for form in verb}


def forms(verbs: tuple[Verb, ...], *which: Form) -> str:
    """Return a pattern of the given forms of verbs, of all of them where none is given."""
    places = [_FORMS.index(form) for form in which or _FORMS]
    return f"(?:{'|'.join(sorted({verb[at] for verb in verbs for at in places}))})"


def base_of(word: str) -> str | None:
    """Return the base form of a word for motion, such as "turn" of "turned"; None of any other."""
    return _BASES.get(word)
