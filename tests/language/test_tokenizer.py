import pytest

from geotlm_lm.language.tokenizer import byte_pairs

CORPUS = ["which way is the cap turning?", "turning 12 degrees, turning 12 mm"] * 4


@pytest.fixture(scope="module")
def tokenizer():
    return byte_pairs(CORPUS, 300)


def test_digits_stay_single(tokenizer):
    assert [t.strip("Ġ") for t in tokenizer.encode("12 12345").tokens if t != "Ġ"] == list(
        "1212345"
    )


@pytest.mark.parametrize(
    "text", ["which way?", "\u00fcber 3\u00b0 \u2192 \u6f22\u5b57 \U0001f600", "a\tb"]
)
def test_any_text_is_spelled_and_read_back(tokenizer, text):
    assert tokenizer.decode(tokenizer.encode(text).ids, skip_special_tokens=False) == text
