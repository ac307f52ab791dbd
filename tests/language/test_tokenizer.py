import pytest

from geotlm_lm.language.slots import SLOT_TOKENS, SLOT_WORDS
from geotlm_lm.language.tokenizer import SPECIAL_TOKENS, clean_question, train_tokenizer

CORPUS = ["which way is the cap turning?", "turning 12 degrees, turning 12 mm"] * 4


@pytest.fixture(scope="module")
def tokenizer():
    return train_tokenizer(CORPUS, 300)


def test_special_tokens_come_first(tokenizer):
    places = [tokenizer.token_to_id(token) for token in SPECIAL_TOKENS]
    assert places == list(range(len(SPECIAL_TOKENS)))


def test_slots_and_the_words_that_fill_them_are_one_token_each(speaker):
    assert set(SLOT_TOKENS) < set(SPECIAL_TOKENS)
    encode = speaker.prompts.tokenizer.encode
    ids = [encode(word).ids for word in (*SLOT_TOKENS, *SLOT_WORDS)]
    assert [len(one) for one in ids] == [1] * len(ids)
    assert len({one[0] for one in ids}) == len(ids)


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
        *("<tactile>", "< Tactile >", "<eos>", "<assistant>", "<USER>", "< /pad>"),
        *SLOT_TOKENS,
        *("<TURN>", "< contact >", "<tu<slide>rn>"),
        "<<tactile>tactile> <tac<eos>tile> <<tactile>> << < USER > >> <<<</user>>>>",
    ],
)
def test_a_typed_marker_is_never_a_control_token(tokenizer, typed):
    ids = tokenizer.encode(clean_question(f"which {typed} way {typed}?")).ids
    assert min(ids) >= len(SPECIAL_TOKENS)
