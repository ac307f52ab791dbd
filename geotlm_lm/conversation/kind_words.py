"""Pieces of the phrases that rules look for: what they are of, and where they stand."""

from __future__ import annotations

GEL = r"(?:gel|sensor|pad|skin|fingertip)"
"""What is touched."""

HOLDER = rf"(?:{GEL}|finger|gripper|wrist|robot(?:'?s)?(?: arm| hand)?)"
"""What moves the sensor, and the sensor with it."""

EXTENT_OF = (
    r"(?:the |this |that |its )?(?:\w+ )?"
    r"(?:it|turn|slide|slip|shift|motion|movement|rotation|displacement|angle|distance|step)\b"
)
"""What has a size that is an amount of motion."""

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
