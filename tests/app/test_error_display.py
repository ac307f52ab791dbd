"""Errors reach the page as one harmless sentence, and programs as they are."""

import pytest

gradio = pytest.importorskip("gradio", reason="the page needs gradio (extra: app)")

from app.error_display import literal, with_errors_shown  # noqa: E402

from geotlm_lm import GeoTLMError  # noqa: E402

SENTENCE = "<img src=x onerror=alert(1)>.npy: is empty; frames 3 < 4."


def fail():
    raise GeoTLMError(SENTENCE)


def fail_late():
    yield 1
    raise GeoTLMError(SENTENCE)


def test_markup_in_a_files_name_is_not_rendered():
    with pytest.raises(gradio.Error) as caught:
        with_errors_shown(fail)()
    assert "<img" not in caught.value.message
    assert "&lt;img" in caught.value.message


def test_a_program_gets_the_sentence_itself():
    with pytest.raises(gradio.Error) as caught:
        with_errors_shown(fail, is_page=False)()
    assert caught.value.message == SENTENCE


def test_what_came_before_the_mistake_is_kept():
    stream = with_errors_shown(fail_late)()
    assert next(stream) == 1
    with pytest.raises(gradio.Error, match="is empty"):
        next(stream)


def test_a_defect_is_not_taken_for_a_mistake():
    def broken():
        raise ZeroDivisionError("a defect")

    with pytest.raises(ZeroDivisionError):
        with_errors_shown(broken)()


@pytest.mark.parametrize(
    ("text", "markdown"),
    [
        ("![x](http://a.b/c)", r"\!\[x\]\(http\:\/\/a\.b\/c\)"),
        ("<img src=x>", r"\<img src\=x\>"),
        ("&lt; `a` **b** $c$", r"\&lt\; \`a\` \*\*b\*\* \$c\$"),
        ("- a note, 3-4", r"- a note\, 3-4"),
    ],
)
def test_markup_is_shown_as_it_is(text, markdown):
    assert literal(text) == markdown
