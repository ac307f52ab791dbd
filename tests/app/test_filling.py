"""Parts are filled by their names, and a mistake is told until something else works."""

from app.filling import COMPLAINT, filling

from geotlm_lm import GeoTLMError

PARTS = {"chat": "the chat", COMPLAINT: "the complaint"}


def test_a_complaint_is_emptied_once_by_what_runs_on():
    def runs_on():
        yield {"chat": 1}
        yield {"chat": 2}  # another mistake may have been told meanwhile

    assert list(filling(PARTS, runs_on)()) == [
        {"the complaint": "", "the chat": 1},
        {"the chat": 2},
    ]


def test_a_mistake_is_told_as_it_was_said():
    def fails():
        yield {"chat": 1}
        raise GeoTLMError("<b>.npy is empty; record it again.")

    *_, told = filling(PARTS, fails)()
    assert told == {"the complaint": "&lt;b&gt;.npy is empty; record it again."}


def test_what_shows_nothing_empties_no_part():
    assert list(filling(PARTS, lambda: iter(()))()) == [{"the complaint": ""}]
