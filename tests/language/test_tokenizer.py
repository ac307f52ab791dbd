import pytest

from geotlm_lm.language.tokenizer import SPECIAL_TOKENS, clean_question, train_tokenizer

CORPUS = ["which way is the cap turning?", "turning 12 degrees, turning 12 mm"] * 4


@pytest.fixture(scope="module")
def tokenizer():
    return train_tokenizer(CORPUS, 300)


def test_special_tokens_come_first(tokenizer):
    assert [tokenizer.token_to_id(token) for token in SPECIAL_TOKENS] == [0, 1, 2, 3, 4]


def test_digits_stay_single(tokenizer):
    assert [t.strip("Ġ") for t in tokenizer.encode("12 12345").tokens if t != "Ġ"] == list(
        "1212345"
    )


@pytest.mark.parametrize(
    "text", ["which way?", "\u00fcber 3\u00b0 \u2192 \u6f22\u5b57 \U0001f600", "a\tb"]
)
def test_any_text_is_spelled_and_read_back(tokenizer, text):
    assert tokenizer.decode(tokenizer.encode(text).ids, skip_special_tokens=False) == text


@pytest.mark.parametrize(
    "typed",
    [
        *("<tactile>", "< Tactile >", "<eos>", "<assistant>", "<USER>"),
        "<<tactile>tactile> <tac<eos>tile> <<tactile>> << < USER > >> <<<</user>>>>",
    ],
)
def test_a_typed_marker_is_never_a_control_token(tokenizer, typed):
    ids = tokenizer.encode(clean_question(f"which {typed} way {typed}?")).ids
    assert min(ids) >= len(SPECIAL_TOKENS)


def test_a_question_is_one_line_in_lower_case():
    assert clean_question("  Which\n WAY? ") == "which way?"
