"""An unknown command, option, value or name is answered with the nearest, else with all."""

import pytest

from geotlm_lm.core.errors import choice_of, nearest
from tests.cli.running import run


def test_the_nearest_name_is_asked_for_else_all_are_listed():
    assert choice_of("Kye", ["coin", "key"]) == "did you mean 'key'?"
    assert choice_of("unicorn", ["coin", "key"]) == "choose one of coin, key."
    assert nearest("x" * 10**6, ["coin"]) is None


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("trakc",), "No such command 'trakc'. Did you mean 'track', 'train'?"),
        (("track", "--plto", "x"), "No such option: --plto. Did you mean '--plot'?"),
        (("bench", "acuracy"), "No such command 'acuracy'. Did you mean 'accuracy'?"),
        (("train", "--preset", "dfault", "--out", "x"), "there is no preset 'dfault'; did you me"),
        (("simulate-clip", "x.npz", "--object", "kye"), "There is no shape 'kye'; did you mean 'k"),
        (
            ("simulate-clip", "x.npz", "--motion", "clokwise"),
            "Invalid value for '--motion': there is no 'clokwise'; did you mean 'clockwise'? See ",
        ),
        (("bench", "accuracy", "--only", "clps"), "--only 'clps' is unknown; did you mean 'clips'"),
        (("track", "tests/cli/runing.py"), "tests/cli/runing.py: no such file or folder; did you"),
    ],
)
def test_what_is_mistyped_is_answered_with_what_was_meant(capsys, arguments, sentence):
    code, out, err = run(capsys, *arguments)
    assert (code in (2, 3), out) == (True, "")
    assert err.startswith(sentence)
    assert err.count("\n") == 1
