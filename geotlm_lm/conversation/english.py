"""Detect questions that are surely not English; in doubt a text is English.

Knows a few hundred common words. Terse questions, typos and made-up names must pass.
"""

from __future__ import annotations

import re
import unicodedata

ENGLISH_ONLY = "I read English only; please ask in English."

_ENGLISH = """
about all am an and any anything are as at backwards be been big by can ccw clockwise colour contact
could counterclockwise cw did direction do does down even far fast feel for from give go goes going
had has have held how i if in into is isn't it its just kind left me mirrored more motion move moved
movement moves moving much must my no not now object of off on one only or other out please pressing
right rotate rotating said same say see seen sensor should side slide sliding slip slipping so
something still sure tell than that the them then there these they thing this to touch touched
touching turn turned turning twist type undo up was way we went were what what's when where which
while who why will with would wrong yes you your
"""

_FOREIGN = (
    # German, Dutch, Swedish, Danish
    """
wie welche welcher welches wohin warum dreht drehen bewegt sich richtung gegenstand objekt ist nicht
der das und oder ein eine im uhrzeigersinn links rechts oben unten berührt etwas wird
beweegt draait welke richting waarom hoe het een naar niet linksom rechtsom raakt iets
vilken vilket riktning rör sig vad hur är det åt vänster höger snurrar
hvilken hvordan retning drejer bevæger hvad og
"""
    # French, Spanish, Italian, Portuguese, Romanian
    """
quel quelle quels dans sens tourne bouge est-ce que l'objet objet il elle vers gauche droite
pourquoi comment le les une des du glisse touche
qué cuál cómo hacia dónde dirección gira mueve objeto izquierda derecha el los las una se está por
quale direzione verso muove oggetto l'oggetto sinistra destra che cosa perché lo gli si sta è
qual direção sentido esquerda direita o para onde você
direcție rotește mișcă obiectul încotro este
"""
    # Polish, Czech, Turkish, Finnish, Hungarian, Indonesian
    """
w jakim którą kierunku stronę obraca się porusza czy przedmiot jak gdzie
kterým směrem otáčí pohybuje předmět kam je
hangi yöne yönde dönüyor hareket ediyor nesne nasıl mı
mihin suuntaan pyörii liikkuu esine onko mitä
melyik irányba forog mozog tárgy merre
ke arah mana benda bergerak berputar apakah yang
"""
)

ENGLISH = frozenset(_ENGLISH.split())
FOREIGN = frozenset(_FOREIGN.split()) - ENGLISH

_LETTERS = re.compile(r"[^\W\d_]+(?:['’-][^\W\d_]+)*")


def is_english(text: str) -> bool:
    """Tell whether `text` may be English.

    It is not where most letters are of another script, or where common words of other languages
    outnumber the English ones.
    """
    letters = [character for character in text if character.isalpha()]
    if not letters:
        return True
    latin = sum(unicodedata.name(letter, "").startswith("LATIN") for letter in letters)
    if latin < len(letters) / 2:
        return False
    words = [word.lower().replace("’", "'") for word in _LETTERS.findall(text)]
    foreign = sum(word in FOREIGN for word in words)
    english = sum(word in ENGLISH for word in words)
    return foreign <= english
