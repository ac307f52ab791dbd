"""Tell a value in a sentence: what is asked first, short, one reason where it helps.

The point of view is named where a way is told and another was named before. Numbers are rounded to
their tolerance and are the same wherever they stand.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from geotlm_lm.core.edit import opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.phrases import (
    DENIED,
    KIND_WORDS,
    TRAIT_WORDS,
    all_of,
    amount_phrase,
    count_phrase,
    file_phrase,
    joined,
    label_of,
    limit_phrase,
    movement_phrase,
    replies,
    undoing_phrase,
    unit_phrase,
    way_phrase,
    where_phrase,
    which_phrase,
)
from geotlm_lm.query.program import (
    TRAITS,
    WAY_ATOMS,
    Expression,
    head_of,
    measure_of,
    type_of,
)
from geotlm_lm.query.stories import MOST_TOLD, Narrator, consecutive, is_from_to, most
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Moved,
    Movement,
    Placed,
    Record,
    Remark,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.track.events import MOVING

_REST = {Motion.STILL: "it touches but does not move", Motion.NONE: "nothing touches the gel"}
OFF_CENTRE = 1 / 6
"""Share of the image's side from its middle beyond which a place is no longer the middle's."""


@dataclass(frozen=True)
class Wording:
    """A sentence, and the point of view that was named last, in it or before."""

    text: str
    named: str | None = None


@dataclass(frozen=True)
class Teller(Narrator):
    """Tells values of one recording in one frame."""

    def tell(self, value: Value) -> Wording:
        """Return a value as a sentence."""
        if isinstance(value, Unknown) and value.supposing is not None:
            return self._supposed(value.supposing)
        if isinstance(value, Unknown):
            return Wording(self._missing(value), self.named)
        text = _sentence(_TELLERS[type(value)](self, value))
        where = where_phrase(value.edit, self.frame)
        return Wording(text, where if where in text else self.named)

    def _missing(self, value: Unknown) -> str:
        """Return why something cannot be told."""
        text = replies()["missing"][value.reason]
        if value.at_s is not None:
            text = text.format(self.moment(value.at_s))
        lacking = None if value.lacking is None else which_phrase(value.lacking)
        return f"{text if lacking is None else f'There is no {lacking}.'} {value.detail}".strip()

    def _supposed(self, value: Value) -> Wording:
        """Return what a value is on an ordinary thread, what is not known of it named first."""
        lacks = self.frame.missing_for_thread()
        supposed = " an ordinary right-hand thread" if "thread" in lacks else ""
        supposed += " seen from its head" if "contact_side" in lacks else ""
        wording = self.tell(value)
        text = f"If it is{supposed}, {wording.text[:1].lower()}{wording.text[1:]}"
        return replace(wording, text=text)


# What each value is told as


def _truth(teller: Teller, value: Truth) -> str:
    head = head_of(value.of)
    if head.word == "sure-of":
        instead = value.chance < 0.5 and value.motion is not None and value.motion.movements
        clause = f": {_clause(teller, value.motion)}" if instead else ""
        return f"about {value.chance:.0%}{clause}"
    word = "yes" if value.holds else "no"
    if head.word == "not":  # a bare "no" to a denial could be read either way
        word += ", that is so" if value.holds else ", that is not so"
    reason = _reason(teller, value, head)
    if not reason:
        return word
    is_short = reason.startswith(("from ", "at ", "about ", "net "))
    return f"{word}{',' if is_short else ':'} {reason}"


def _reason(teller: Teller, value: Truth, head: Expression) -> str:
    """Return the one thing that a yes or no rests on."""
    while head.word == "not":
        head = head_of(head.arguments[0])
    if value.each:
        return _each(teller, value.each)
    if value.times_s:
        return f"at {joined([teller.moment(each) for each in value.times_s[:3]])}"
    if value.amounts:
        compared = value.amounts[0]
        first = compared.amount
        if first.deviation > abs(first.mean) and not value.holds:  # it may well be nothing
            high = replace(first, mean=max(map(abs, first.span)), deviation=0.0)
            return f"at most {high.limit:g}{unit_phrase(high)}"
        way = WAY_ATOMS.get(first.atom)
        if way is not None and first.value < 0:  # the other way
            first = replace(first, mean=-first.mean)
            return f"about {amount_phrase(first)} {opposite(way).value}"
        is_about = first.deviation > 0 and (first.unit != "" or first.tolerance > 0)
        text = f"{'about ' * is_about}{amount_phrase(first)}"
        if compared.at_s is not None:
            return f"{text} at most, at {teller.moment(compared.at_s)}"
        moves = value.motion.movements if value.motion is not None else ()
        path = next((move.path for move in moves if move.path is not None), None)
        if path is None or path.atom != first.atom:
            return text
        is_path = measure_of(head_of(compared.of)).word == "path"
        others = "" if is_path else f", {amount_phrase(path)}"
        return f"{'net ' * (not is_path)}{text}{others} there and back"
    motion = value.motion
    if motion is None or head.word in _SELF_EVIDENT:
        return ""
    moves = motion.movements
    asked = {move.component for move in moves} - set(motion.denied)
    if not moves or motion.denied and value.holds:
        return _clause(teller, motion)
    first = moves[0]
    parts = consecutive(value)
    if head.word in ("tighten", "loosen") and not parts:
        return _clause(teller, motion)
    if parts:
        way = WAY_ATOMS.get(head.word)
        own = [each for each in parts if each.way is way] if value.holds and way else parts
        return teller.story(value, most(own or parts, 2))
    is_asked = first.component in asked and head.word in TRAITS
    if value.holds and is_asked and first.times is not None and len(moves) == 1:
        way = f"{way_phrase(first)}, " if head.word in ("turn", "slide", "move") else ""
        own = [each for each in value.shown if each.way is WAY_ATOMS.get(head.word)]
        ends = [(each.begin_s, each.end_s) for each in own] or [first.times]
        times = min(begin for begin, _ in ends), max(end for _, end in ends)
        return f"{way}{teller.span(times)}{teller.where(motion, [first.way] if way else [])}"
    if value.holds and is_asked and head.word in ("turn", "slide", "move"):
        return f"{joined([way_phrase(move) for move in moves])}{teller.where(motion, [first.way])}"
    if value.holds and is_asked and first.amount is not None:
        return f"about {amount_phrase(first.amount)}{teller.where(motion, [first.way])}"
    return _clause(teller, motion)


_SELF_EVIDENT = ("touch", "none", "lies", "ever", "always", "speeds-up", "slows-down", "happens",
                 "before", "after")  # fmt: skip
"""Truths that no motion is a reason of."""


def _each(teller: Teller, values: Sequence[Value]) -> str:
    """Return what is so of each of two clips: "the first turns left, the second about 3 px"."""
    parts = [f"the {value.clip} {_in_short(teller, value)}" for value in values]
    ways = [way for value in values if isinstance(value, Moved) for way in value.ways]
    return f"{', '.join(parts)}{teller.where(values[-1], ways)}"


def _in_short(teller: Teller, value: Value) -> str:
    if isinstance(value, Truth):
        return "yes" if value.holds else "no"
    if isinstance(value, Amount):
        text = f"{'about ' * (value.amount.deviation > 0)}{amount_phrase(value.amount)}"
        return f"{_extent_word(value)}{text}"
    if isinstance(value, Moved):
        if value.denied:
            return f"does not {_denied(value)}"
        if not value.movements:
            is_free = value.rest is Motion.NONE
            return "touches nothing" + " then" * value.is_brief if is_free else "does not move"
        return all_of([movement_phrase(move) for move in value.movements])
    return teller.tell(value).text.rstrip(".").lower()


def _denied(motion: Moved) -> str:
    """Return what of the asked does not move, and from how much on that would be seen."""
    limits = dict(motion.limits)
    return " or ".join(DENIED[each] + limit_phrase(limits.get(each, ())) for each in motion.denied)


def _clause(teller: Teller, motion: Moved) -> str:
    """Return what moves, what of the asked does not, and the frame where a way is named."""
    who = teller.who(motion)
    limits, denied = dict(motion.limits), _denied(motion)
    if motion.still_axis is not None:
        denied = f"slide {TRAIT_WORDS[motion.still_axis]}"
    if motion.rest is not None:
        if denied and motion.rest is Motion.STILL:
            return f"{who} does not {denied}"
        rest = _REST[motion.rest] + " then" * motion.is_brief
        if motion.rest is Motion.STILL:
            rest += limit_phrase(limits.get(Component.SLIDE, ()))
        return f"{who} does not {denied}: {rest}" if denied else rest
    ways = motion.ways
    if motion.edit.undo:
        if denied:
            return f"{who} does not {denied}: nothing of that is to be undone"
        undoing = undoing_phrase(motion.movements, motion.edit)
        return f"{undoing}, {where_phrase(motion.edit, teller.frame)}"
    if denied:
        return f"{who} does not {denied}"
    goes = all_of([movement_phrase(move) for move in motion.movements])
    return f"{who} {goes}{teller.where(motion, ways)}"


def _amount(teller: Teller, value: Amount) -> str:
    head = head_of(value.of)
    amount, motion = value.amount, value.motion
    is_exact = amount.deviation == 0 and (amount.decimals is not None or amount.tolerance == 0)
    text = f"{'' if is_exact else 'about '}{amount_phrase(amount, with_span=True)}"
    if head.word == "count":
        return count_phrase(amount, head.arguments[0])
    head = measure_of(head)
    if head.word == "clock" and amount.unit == "frame":
        return f"frame {amount.figure}"
    if value.at_s is not None:
        farthest = "at its farthest " * (head.word == "amount")
        text = f"{farthest}{text}, at {teller.moment(value.at_s)}"
    is_back = motion is not None and any(move.path is not None for move in motion.movements)
    if is_back and head.word == "amount" and value.at_s is not None:
        return f"{text}; {_net(motion.movements[0])}"
    # What came back got farthest another way than it went in all.
    is_farther = value.at_s is not None and (
        head.word == "amount" or (head.word == "peak" and not _ends_there(value))
    )
    is_of_a_way = head.word in ("amount", "net", "speed") or (
        head.word in ("peak", "top-speed") and not is_back
    )
    if value.both:
        way = WAY_ATOMS[head.arguments[0]]
        there, back = map(amount_phrase, value.both)
        gone = f"{there} {way.value} and {back} {opposite(way).value}"
        net_text = f": net {text}" if head.word == "net" else ""
        return f"{gone}{teller.where(motion, [way])}{net_text}"
    if is_of_a_way and not is_farther and motion is not None and motion.movements:
        ways = motion.ways
        named = joined([way_phrase(move) for move in motion.movements])
        text += f": {named}{teller.where(motion, ways)}"
        path = motion.movements[0].path
        if head.word in ("amount", "net") and path is not None:
            text = f"net {text}; {amount_phrase(path)} there and back"
    return f"{text}, there and back together" if head.word == "path" and _goes_back(value) else text


def _goes_back(value: Amount) -> bool:
    """Tell whether something goes more than one way, as far as it is known what it goes when."""
    if value.amount.atom in WAY_ATOMS:  # all that goes that way
        return False
    ways = {each.way for each in value.shown if each.kind in MOVING}
    return not value.shown or len(ways) > 1


def _extent_word(value: Amount) -> str:
    """Return which amount of what does not go one way only is told: "at its farthest ", "net "."""
    if measure_of(head_of(value.of)).word not in ("amount", "net"):
        return ""
    if value.at_s is not None:
        return "at its farthest "
    moves = () if value.motion is None else value.motion.movements
    return "net " * any(move.path is not None for move in moves)


def _ends_there(value: Amount) -> bool:
    """Tell whether something ends about where it got farthest."""
    moves = () if value.motion is None else value.motion.movements
    net = next((move.amount for move in moves if move.amount is not None), None)
    if net is None or net.unit != value.amount.unit:
        return False
    return abs(net.value) >= abs(value.amount.value) / 2


def _net(move: Movement) -> str:
    """Return what is left of a motion that came back: "net 2 degrees counterclockwise"."""
    return f"net {amount_phrase(move.amount)} {move.way.value}" if move.amount else "and back"


def _times(teller: Teller, value: Times) -> str:
    head = head_of(value.of)
    times = value.times_s
    if not times:
        return "that does not happen in this recording"
    if type_of(head) == "event" and len(times) == 2:
        own = [each for each in value.shown if each.kind in MOVING and is_from_to(each, times)]
        if len(own) == 1:
            return teller.story(value, own)
    if len(times) == 2 and head.word not in ("begins", "ends"):
        return teller.span((times[0], times[1]))
    return f"at {joined([teller.moment(each) for each in times])}"


def _moved(teller: Teller, value: Moved) -> str:
    head = head_of(value.of)
    if head.word == "story":
        kept = most(value.shown, MOST_TOLD)
        return teller.story(value, kept, value.shown) or _clause(teller, value)
    if head.word == "kind":
        return _kind(teller, value)
    if head.word == "sure":
        return f"about {value.probability:.0%}: {_clause(teller, value)}"
    if head.word == "sure-amount":
        spans = [amount_phrase(move.amount, with_span=True)
                 for move in value.movements if move.amount is not None]  # fmt: skip
        return f"about {'; '.join(spans)}" if spans else _clause(teller, value)
    if value.tightens is not None:
        return f"it {'tightens' if value.tightens else 'loosens'}: {_clause(teller, value)}"
    parts = consecutive(value) if head.word in ("way", "extent") else []
    if value.of.word == "at":  # what goes on then, from when to when
        parts = [each for each in value.shown if each.kind in MOVING]
        if not parts and value.denied:
            return f"{_clause(teller, value)} at that moment"
    if head.arguments == ("thread",) and value.movements and not value.denied:
        how = teller.story(value, parts) if parts else _clause(teller, value)
        return f"it tightens and loosens, one after the other: {how}"
    if value.edit.undo or not parts:
        return _clause(teller, value)
    return teller.story(value, parts, value.shown)


def _kind(teller: Teller, value: Moved) -> str:
    if value.rest is not None and value.shown:  # of an event that is no motion
        return f"a {value.shown[0].kind.value}"
    if value.rest is not None:
        rest = {Motion.STILL: "a still contact", Motion.NONE: "no contact"}[value.rest]
        return rest + " then" * value.is_brief
    kinds = [KIND_WORDS[move.component] for move in value.movements]
    ways = value.ways
    named = joined([way_phrase(move) for move in value.movements])
    return f"a {' and a '.join(kinds)}: {named}{teller.where(value, ways)}"


def _choice(teller: Teller, value: Choice) -> str:
    head = head_of(value.of)
    if head.word == "alternatives":
        return _alternatives(value)
    if head.word in ("which-clip", "which-more", "which-less"):
        which = " and ".join(f"the {('first', 'second')[place]}" for place in value.chosen)
        reason = f": {_each(teller, value.each)}" if value.each else ""
        return f"{which or 'neither' + ' clearly' * bool(reason)}{reason}"
    cases = [head.arguments[0][place] for place in value.chosen]
    names = list(map(label_of, cases))
    if head.word == "choose-not":
        return f"not {joined(names)}" if names else "none of them can be ruled out"
    if not names and len(value.times_s) == 2:
        return f"neither: {joined(sorted({f'at {teller.moment(each)}' for each in value.times_s}))}"
    if not names:
        return (
            f"none of these: {_clause(teller, value.motion)}" if value.motion else "none of these"
        )
    both = "both: " * (len(names) == 2 == len(head.arguments[0]))
    motion = value.motion
    if motion is None or (not motion.movements and motion.rest is None):
        return f"{both}{joined(names)}"
    is_way = any(case.label is None and case.holds.word in WAY_ATOMS for case in cases)
    ways = motion.ways if is_way else []
    return f"{both}{joined(names)}{teller.where(motion, ways)}"


def _alternatives(value: Choice) -> str:
    """Return the likeliest ways and rests, each with its probability."""
    ways = (way.value for way in WAY_ATOMS.values())
    words = [*ways, "holding still", "no contact"][: len(value.chances)]
    ranked = sorted(zip(value.chances, words, strict=False), reverse=True)
    likely = [f"{word} {chance:.0%}" for chance, word in ranked[:3] if chance >= 0.01]
    return joined(likely or [f"{ranked[0][1]} {ranked[0][0]:.0%}"])


def _place(_: Teller, value: Placed) -> str:
    places = ((value.down, "upper", "lower"), (value.across, "left", "right"))
    named = [
        before if share < 0.5 else behind
        for share, before, behind in places
        if abs(share - 0.5) > OFF_CENTRE
    ]
    part = " ".join(named) if len(named) == 2 else f"{named[0]} middle" if named else "middle"
    return (
        f"in the {part} of the image, its middle at {value.across:.0%} of the width and "
        f"{value.down:.0%} of the height; it covers about {value.share:.0%}"
    )


def _record(teller: Teller, value: Record) -> str:
    parts = []
    for key, each in value.fields:
        name = f"the {each.clip}: " if each.clip else f"{key}: " if key else ""
        wording = teller.tell(each)
        teller = replace(teller, named=wording.named)
        text = wording.text.rstrip(".")
        parts.append(f"{name}{text[:1].lower()}{text[1:]}")
    return "; ".join(parts) or "none"


def _remark(teller: Teller, value: Remark) -> str:
    if value.kind == "cannot":
        return replies()["untold"][value.topic]
    if value.kind == "talk":
        return replies()["talk"][value.topic]
    if value.kind == "setup":
        return f"I tell it in this frame: {teller.frame.sentence()}"
    if value.kind == "file":
        return file_phrase(value.topic, value.recording or teller.recording, teller.frame)
    return replies()["help"]


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + "." * (text[-1:] not in ".?!")


_TELLERS: dict[type[Value], Callable[[Teller, Value], str]] = {
    Truth: _truth,
    Amount: _amount,
    Times: _times,
    Moved: _moved,
    Choice: _choice,
    Record: _record,
    Placed: _place,
    Remark: _remark,
}
