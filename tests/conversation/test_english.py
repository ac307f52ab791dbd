import numpy as np
import pytest

from geotlm_lm.conversation.english import is_english
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for, with_typo

OTHERS = {
    "German": ("In welche Richtung dreht sich der Deckel?", "Wohin bewegt es sich?", "Wohin?"),
    "French": ("Dans quel sens tourne l'objet ?", "Est-ce que ça bouge vers la gauche ?"),
    "Spanish": ("¿En qué dirección gira la tapa?", "¿Se mueve hacia la izquierda?"),
    "Italian": ("In quale direzione gira l'oggetto?", "Verso sinistra o destra?"),
    "Portuguese": ("Em qual direção o objeto gira?", "Está se movendo para a esquerda?"),
    "Dutch": ("In welke richting draait het voorwerp?", "Draait het linksom?"),
    "Polish": ("W jakim kierunku obraca się przedmiot?", "Czy się porusza?"),
    "Turkish": ("Nesne hangi yöne dönüyor?", "Hareket ediyor mu?"),
    "Swedish": ("Åt vilket håll snurrar det?", "Vad är det för riktning?"),
    "Russian": ("В какую сторону вращается крышка?", "Куда?"),
    "Chinese": ("盖子往哪个方向转？", "它在动吗？"),
    "Japanese": ("どちらに回っていますか？", "動いていますか"),
    "Arabic": ("في أي اتجاه يدور الغطاء؟",),
    "Korean": ("어느 방향으로 돌고 있나요?",),
    "Greek": ("Προς τα πού γυρίζει;",),
    "Hindi": ("यह किस दिशा में घूम रहा है?",),
}

ENGLISH = """
which way?
direction?
cw?
CCW
cw or ccw
left?
up
left or right
moving?
contact
touching anything
spin
how far
how fast??
deg per second
mm?
A) left B) right
(a) cw (b) ccw
sure?
why
whch way is teh cap trning
Waht direction plz
clockwise pls
pls tell me which way thx
yo is it goin left or nah
r u sure
no
undo?
mirrored?
backwards
Which way does the piñata turn?
Is my café mug turning?
is the Brötchen sliding left
Which way is Müller's knob turning?
la lid: which way?
Is the die turning?
Is the den door moving?
was it still?
Die plate: which way?
What does het sensor feel?
Robot, report motion.
GRIPPER: STATE DIRECTION
turn?
slipping?
screw tighter?
lefty loosey or righty tighty
has it started creeping
is it drifting to the east
twelve degrees?
1 + 1?
¿which way?
""".strip().splitlines()


@pytest.mark.parametrize(
    "question", [text for texts in OTHERS.values() for text in texts], ids=lambda text: text[:20]
)
def test_a_question_in_another_language_is_noticed(question):
    assert not is_english(question)


def test_there_are_ten_languages_and_fifty_english_questions():
    assert len(OTHERS) >= 10
    assert len(ENGLISH) >= 50


@pytest.mark.parametrize("question", ENGLISH)
def test_an_english_question_is_english_however_terse(question):
    assert is_english(question)


def test_no_question_of_the_templates_is_foreign_not_even_mistyped():
    rng = np.random.default_rng(3)
    asked = [
        one.question
        for wordings in ("seen", "held_out")
        for motion in Motion
        for one in questions_for(MotionLabel(motion), rng, wordings=wordings, per_type=8)
    ]
    assert [text for text in asked if not is_english(text)] == []
    mistyped = [with_typo(text, rng) for text in asked]
    assert [text for text in mistyped if not is_english(text)] == []


def test_digits_and_marks_alone_are_no_foreign_language():
    assert is_english("12 ?!")
