"""Patterns of each kind of question that rules recognise, as data; `kinds` reads them."""

from __future__ import annotations

from geotlm_lm.conversation.axis_claims import COMPONENTS
from geotlm_lm.conversation.clip_names import CLIP, FIRST_OR_SECOND
from geotlm_lm.conversation.kind_words import (
    ALONE,
    EXTENT_OF,
    FILM,
    GEL,
    HOLDER,
    LEADS,
    MOMENT,
    PICTURE,
    SUPPOSED,
)
from geotlm_lm.conversation.motion_verbs import GOES, SLIDES, TURNS, forms

_GO = forms(TURNS + SLIDES + GOES, "base", "third", "past")
_ALONG = r"(?:vertically|horizontally|left[ -]to[ -]right|top[ -]to[ -]bottom)"
_MEASURES = r"(?:degrees?|deg|mm|millimet(?:re|er)s?|pixels?|px)"

COUNTED = (
    rf"(?:{_MEASURES}|radians?|rads?|arc ?(?:minutes|seconds)|(?:minutes|seconds) of arc|cm"
    r"|centimet(?:re|er)s?|um|microns?|micromet(?:re|er)s?|inch(?:es)?|turns|revolutions?|rotations?)"
)
"""What is counted of a motion."""

MOVEMENT = r"(?:rotation|turn(?:ing)?|slip|slide|sliding|travel|motion)"
"""A motion, as a noun."""

_MOVES_OR_END = (
    rf"(?: {_GO}\b| (?:make|itself)\b"
    rf"| {forms(TURNS + SLIDES + GOES, 'gerund')}\b| in {COUNTED}\b|$|[?,:.])"
)

_EXTENT = (
    r"(?:it|this|that|the (?:answer|result|reply|value)"
    r"|(?:(?:the|its|this|that) )?(?:(?:total|whole|overall|net|full|mean|estimated|measured) )?"
    rf"(?:(?:{MOVEMENT} )?(?:amount|extent|distance|angle)|theta|displacement|shift|movement"
    rf"|{MOVEMENT})(?: of (?:it|(?:(?:the|this|its|my) )?\w+)| (?:that )?(?:it|the \w+) {_GO})?)"
)
"""What is stated in a unit as an amount: the motion's extent, and no place, size or direction."""

RULES: dict[str, tuple[str, ...]] = {
    "thread": (
        r"\b(?:un)?screw(?:ed|ing)\b|\bunscrews?\b|\b(?:it|this|that|he|she|one) screws\b",
        r"\bscrews (?:it|in|out)\b",
        r"\bthe thread (?:turned|turning)\b",
        r"\bout of the thread\b",
        r"\b(?:tight|loos)(?:en|ens|ened|ening|er)\b|\b(?:tight or loose|loose or tight)\b",
        r"\b(?:com(?:e|es|ing)|g[eo]t(?:s|ting)?|work(?:s|ed|ing)?) (?:tight|loose)\b",
        r"\b(?:righty|lefty|tighty|loosey)\b",
    ),
    "undo": (
        r"\b(?:undo|undoes|undone|revert|reverts|restore|restores|cancel)\b",
        r"\b(?:puts?|brings?|gets?) (?:\S+ ){0,3}back\b(?! into)|^(?:and )?(?:which way )?back\W*$",
        r"(?:(?<!going )\bto|\b(?:how|which way) (?:do|can|could|would|must|should) \S+(?: \S+)?"
        r"|\bdo i) go (?:\S+ ){0,3}back\b(?! into| and forth| (?:to the )?(?:left|right|up|down))",
        r"\b(?:turn|rotate|twist|move|slide|push|pull|drag) (?:it|this|that|(?:the|my) \S+) back\b",
        r"\b(?:compensat|counteract)\w*",
        r"\bto return\b",
        r"\breverses? (?:this|it|that|the motion)\b",
    ),
    "mirrored": (
        r"\bmirror\w*\b",
        rf"\bflip(?:s|ped)? (?:(?:a|the|this|my) )?{PICTURE}\b",
        rf"\b{PICTURE} (?:\w+ ){{0,2}}flipped\b",
        rf"{LEADS}flip(?:ped)?(?: {_ALONG})?{ALONE}",
        rf"{SUPPOSED}(?:flipped|upside[ -]down)\b|\bthe flipped direction\b",
        rf"{LEADS}(?:(?:turned|put) )?upside[ -]down{ALONE}",
        r"\b(?:after|in|with) (?:a|the) (?:[\w-]+ (?:to right )?)?flip\b",
    ),
    "order": (
        r"\bnames? the events\b",
        r"\b(?:order|sequence) of (?:events|motions|the motions)\b",
        r"\bin (?:what|which) order\b",
        r"\b(?:in order|one after another|step by step|one by one)\b",
        r"\b(?:came|comes|happen(?:s|ed)) (?:first|last|before|then|after that|next)\b",
        r"\bfirst what\b",
        r"\bwhat first\b",
        r"\bfirst,? (?:and )?(?:what )?then\b",
        r"\bbefore (?:it|or after)\b",
        r"\bslide before\b",
        r"\bturn before\b",
        r"\bhow many (?:motions|events|steps)\b",
        r"(?<!\bin this )(?<!\bin that )(?<!\bin the )\bsequence\b",
        r"\b(?:do|does|did) (?:first|last|after that|at the (?:end|start))\b",
        r"(?:^|[:,!] |so |and |ok |hey )(?:and then|then what|what then|what next then)\b",
        r"\b(?:steps|events|motions) (?:happened|are there|did you feel)\b",
        r"\blist\b",
        r"\bevents\b",
    ),
    "reversed": (
        r"\b(?:play(?:s|ed|ing)?|shown?|watch(?:ed|ing)?|in|when|if)(?: it)?"
        r" (?:backwards?|reversed?)\b",
        rf"{LEADS}(?:backwards?|reversed?){ALONE}",
        rf"\b{FILM} (?:\w+ ){{0,2}}(?:backwards?|reversed?)\b",
        rf"\breversed? (?:(?:the|this|that|my) )?{FILM}\b",
        rf"{SUPPOSED}(?:run )?(?:backwards?|reversed?)\b",
        r"\bthe reversed? direction\b|\bbackwards? in time\b",
        r"\brew(?:ind|ound)\b",
        r"\blast frame first\b",
        r"\bfrom (?:the )?(?:end|last) to (?:the )?(?:start|beginning|first)\b",
    ),
    "evidence": (
        r"\bhal(?:f|ves)\b",
        r"\b(?:evidence|proof|grounds|reasons?)\b",
        r"\bshear\b",
        r"\bjustify\b",
        r"^(?:(?:and|so|but)[, ]+)?(?:why|why (?:is )?(?:that|so|this)|how come|how so)\W*$",
        r"\b(?:your|the) reasoning\b|^reasoning\W*$|\bon what (?:basis|grounds)\b",
        r"^what (?:did|do) you measure\W*$",
        r"^(?:please )?(?:prove|explain)(?: (?:it|that|this))?(?: please)?\W*$",
        r"\bhow (?:can|could|do|did) you (?:tell|know)\b",
        r"\bfrom what (?:can|could|do|did) you\b",
        r"\bwhy do you (?:say|think|believe)\b",
        r"\bwhat makes you (?:say|think|believe)\b",
        r"\bwhy you think\b",
        r"\bbased? (?:on|that|it)\b",
        r"\bexplain (?:your answer|yourself|that|how you)\b",
        r"\bwhat (?:shows|tells you|proves)\b",
        r"\bhow you (?:know|can tell)\b",
        r"\b(?:which|what) (?:side|part)\b.*\b(?:moves|goes|moved|went)\b",
        r"\b(?:do|feel) the (?:sides|parts)\b",
        r"\bwhy (?:for that|for it)\b",
    ),
    "comparison": (
        r"\b(?:the two|these two|two|both) (?:clips?|motions|of them)\b",
        rf"\bcompared?\b(?! (?:to|with) (?:the|its) (?:\w+ )?{MOMENT}\b)",
        r"\bdiffer\w*\b",
        rf"\bthe (?:first|second|other|last) {CLIP}\b",
        rf"\b{FIRST_OR_SECOND}",
        r"\balike\b",
        r"\bsecond or (?:the )?first\b",
        rf"\bdo they {_GO}\b",
        rf"\b(?:these two|the two|both) {_GO}\b",
        r"\b(?:the )?same (?:way|direction|motion|movement|or|as)\b",
        r"\bof the two\b",
        r"\bof them\b",
        r"\bin both\b",
        r"\b(?:are|were|do|does) (?:both|they|the two|these two|both clips)\b",
        rf"\bwhich (?:one |clip )?{_GO} (?:further|farther|more|less)\b",
        r"\bsame or (?:not|opposite)\b",
        r"\bwhich (?:one|clip) (?:is|was) (?:faster|slower|larger|smaller)\b",
    ),
    "confidence": (
        r"\b(?:how|are you|are you really|are you quite) (?:sure|certain|confident)\b",
        r"\bconfidence\b",
        r"\b(?:certainty|probability|likelihood|likely|probable)\b",
        r"\b(?:sure|certain) about\b",
        r"\btrust\b",
        r"\brely on\b",
        r"\bdoubt\b",
        r"\byou be (?:wrong|mistaken)\b",
        r"\bwould you (?:bet|swear|stake|wager)\b",
        r"\b(?:really|quite) sure\b",
        r"\bchance (?:of that|that)\b",
        r"\bhow (?:good|safe|solid|reliable) is (?:that|your|this)\b",
        r"^(?:(?:really )?sure|certain|positive|really|seriously|honestly)\W*$",
        r"^is (?:this|that) (?:really )?(?:right|correct|true|so|certain|reliable|accurate)\W*$",
        r"\bare you (?:(?:really|quite) )?(?:positive|guessing)\b",
        r"\bhow (?:accurate|precise|exact) (?:is|was) (?:this|that|it)\W*$",
        r"^(?:what(?:'s| is) )?(?:the |your )?uncertainty\W*$",
        r"\b\d+ ?(?:%|percent) (?:sure|certain|confident)\b",
        r"^\W*(?:(?:and|really|is it|are you) )?\d+ ?(?:%|percent)\W*$",
    ),
    "viewpoint": (
        r"\b(?:object|other|opposite|its own)(?:'?s)? (?:own )?(?:side|view|perspective|point)",
        rf"\b(?:from|seen from) (?:behind|the back)\b(?! (?:of )?(?:the|my) (?:camera|{HOLDER}))",
        r"\bthe (?:view|viewpoint) (?:around|to the other)",
        rf"\blook(?:ing|s)? (?:back )?(?:at|towards|into) the {GEL}\b",
        rf"\b(?:who|person|somebody|someone|when|while) (?:faces|facing) the {GEL}\b",
        r"\bflip the viewpoint\b",
        r"\b(?:seen|viewed|looked at) (?:by|from) the object\b",
        r"\bdoes the object see\b",
    ),
    "actor": (
        rf"\b(?:did|does|was|is|has|had|if|only|moved|but|(?:what|how|ask(?:ed|ing)?|tell me|told"
        r"|talk(?:ed|ing)?|direction|know|and|so) about"
        r"|(?:motion|movement|direction|rotation|turn|slide|slip|travel|path) of)"
        rf" (?:the|my) {HOLDER}(?: itself)?{_MOVES_OR_END}",
        rf"(?:^|[:,!] )(?:and|so|now) (?:the|my) {GEL}(?: itself)?{_MOVES_OR_END}",
        rf"^(?:\W*\w+\W+){{0,4}}(?:the|my) {GEL} itself\b",
        rf"\b(?:how|where|which way) (?:the|my) {HOLDER} {_GO}\b",
    ),
    "rate": (
        r"\bhow (?:fast|quick|quickly|slow|slowly|rapid|rapidly|swift|swiftly)\b",
        r"\b(?:speed|rate|velocity|omega)\b",
        r"\bper (?:second|minute|hour)\b",
        rf"\b(?:rpm|rps|{COUNTED} ?/ ?(?:s|sec|min))\b",
        r"\b(?:speeding up|slowing down|accelerat\w*|decelerat\w*)\b",
        r"\b(?:fast|slow|slowly|quick|quickly) or (?:fast|slow|slowly|quick|quickly)\b",
    ),
    "magnitude": (
        COMPONENTS,
        r"\bhow far\b(?! or)",
        rf"\bhow (?:large|big|small) (?:(?:is|was|are|were) )?{EXTENT_OF}",
        r"\bhow (?:large|big|small)(?: (?:is|was) (?:this|that))?\W*$",
        r"\b(?:by )?how much\b",
        r"\b(?:amount|extent|displacement(?! vector\b))\b",
        rf"\bhow many {COUNTED}\b",
        rf"^\W*(?:in )?{COUNTED} ?(?:/|per) ?frame\W*$",
        r"\btheta\b",
        rf"^(?:and |now )?in {COUNTED}(?: (?:please|then|instead|now))?\W*$",
        r"^(?:and )?(?:what(?:'s| is| was) )?(?:the |its )?(?:(?:rotation|turning) )?angle\W*$",
        rf"\b(?:more|less) than \S+ {_MEASURES}\b",
        rf"\b{_MEASURES} or\b",
        r"\b(?:angle or distance|distance or angle)\b",
        rf"\bsize of {EXTENT_OF}",
        r"\b(?:measure|estimate) (?:the motion|the movement|how)\b(?! (?:direction|sense)\b)",
        r"\bthe size\b(?! of\b)",
        rf"\b{MOVEMENT} (?:angle|distance)\b",
        r"\b(?:what(?:'s| is| was) the|by (?:what|which)|give(?: me)? the|tell me the) (?:total )?"
        r"(?:angle|distance)\b(?! (?:between|from|to|of (?:view|the axis)))",
        rf"^(?:the )?(?:angle|distance)(?: in \w+| {_MEASURES})?\W*$",
        rf"\b(?:express|report|give|convert|state)(?: (?:me|us))? {_EXTENT} in {COUNTED}\W*$",
    ),
}
"""Words that tell each kind, in the order the kinds are tried."""
