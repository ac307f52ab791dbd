"""Patterns of words within and around a question that do not change its meaning."""

from __future__ import annotations

JUST = r"(?:(?:just|already|now|still|really|actually|ever|even|truly|indeed) )?"
"""Before a verb: "is it still turning?"."""

WHETHER = (
    r"(?:(?:would you say|do you (?:think|believe)|am i right(?: in thinking)?|i (?:think|guess)"
    r"|i(?:'d| would) say"
    r"|(?:please )?(?:check|say|tell me|verify)|can you (?:tell(?: me)?|check))"
    r"(?: that| whether| if)? )?"
)
"""Before it: "would you say that it is turning?"."""

TAIL = (
    r"(?:[,.:;?]* *(?:please|(?:answer )?yes or no|or not|now|at all|again|yet|already|so far"
    r"|until now|(?:at least )?a (?:bit|little)|(?:in|on) (?:the|this) (?:clip|video|recording)"
    r")|, *(?:right|correct|no|yes)"
    r"|,? *(?:is|was|has|had|did|does|do)(?:n't| not)? (?:it|that|there))*[ ?.!=]*"
)
"""After it: "is it turning now, yes or no?"."""
