"""Fragments that the patterns of `kind_phrases` are built from."""

from __future__ import annotations

GEL = r"(?:gel|sensor|pad|skin|fingertip)"
"""What is touched."""

HOLDER = rf"(?:{GEL}|finger|gripper|wrist|robot(?:'?s)?(?: arm| hand)?)"
"""What moves the sensor, and the sensor with it."""

EXTENDED = (
    r"(?:turn|slide|slip|shift|motion|movement|rotation|displacement|angle|distance|step|twist"
    r"|spin|swivel|drift|creep|translation|skid)"
)
"""A noun for what has a size that is an amount of motion."""

EXTENT_OF = rf"(?:the |this |that |its )?(?:\w+ )?(?:it|{EXTENDED})\b"

PICTURE = r"(?:clip|image|picture|video|recording|camera)"
"""What is mirrored."""

FILM = r"(?:clip|image|picture|video|recording|film|frames?|time|order|playback)"
"""What runs backwards."""

MOMENT = r"(?:frame|image|picture|start|beginning)"
"""What a motion is measured from, within one clip."""

LEADS = r"(?:^|[:,.!] |\b(?:and|now|so|when|if) )"
ALONE = (
    r"(?=\W*$|[:,.?]| (?:please|thanks|be brief|just asking|in (?:this|the) (?:clip|recording))\b)"
)
"""A word between the two is all that is asked: "and mirrored?", "backwards: which way?"."""

SUPPOSED = r"\b(?:if|suppose|imagine) (?:it|this|that) (?:(?:were|was|is|ran|runs|had|been) ){1,2}"
"""Before what is only supposed."""
