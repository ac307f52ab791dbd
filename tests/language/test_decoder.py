import pytest
import torch

from geotlm_lm.language.decoder import merge_prefix


def ids_of(speaker, length=11):
    head = [speaker.prompts.tactile_id] * speaker.model.size.tactile_tokens
    tail = torch.randint(5, 400, (length,), generator=torch.Generator().manual_seed(1)).tolist()
    return torch.tensor([head + tail])


def test_reading_in_two_pieces_equals_reading_at_once(speaker, fused_tokens):
    model, ids = speaker.model, ids_of(speaker)
    embedded = model.embed(ids, model.projector(fused_tokens[:1]))
    places = torch.arange(ids.shape[1])[None]
    whole, _ = model.decoder(embedded, places)
    first, cache = model.decoder(embedded[:, :9], places[:, :9])
    rest = ids.shape[1] - 9
    mask = torch.ones(rest, ids.shape[1], dtype=torch.bool).tril(9)[None, None]
    second, _ = model.decoder(embedded[:, 9:], places[:, 9:], mask, cache)
    # Summation order differs; 1e-5 is ten times the largest difference measured.
    torch.testing.assert_close(torch.cat([first, second], 1), whole, rtol=1e-5, atol=1e-5)


def test_a_later_token_changes_nothing_before_it(speaker, fused_tokens):
    model, ids = speaker.model, ids_of(speaker)
    other = ids.clone()
    other[0, -1] = 401
    prefix, places = model.projector(fused_tokens[:1]), torch.arange(ids.shape[1])[None]
    one, two = (model.decoder(model.embed(x, prefix), places)[0] for x in (ids, other))
    torch.testing.assert_close(one[:, :-1], two[:, :-1], rtol=0, atol=1e-6)
    assert not torch.allclose(one[:, -1], two[:, -1])


def test_prefix_embeddings_stand_where_the_placeholders_stood():
    prefix = torch.arange(12.0).view(2, 2, 3)
    ids = torch.tensor([[0, 2, 2, 9], [2, 2, 8, 9]])
    merged = merge_prefix(torch.zeros(2, 4, 3), ids, prefix, tactile_id=2)
    assert torch.equal(merged[0, 1:3], prefix[0])
    assert torch.equal(merged[1, 0:2], prefix[1])
    assert not merged[ids != 2].any()


def test_a_wrong_number_of_placeholders_is_refused():
    with pytest.raises(ValueError, match=r"hold \[1\] tactile placeholders"):
        merge_prefix(torch.zeros(1, 3, 4), torch.tensor([[2, 5, 6]]), torch.zeros(1, 2, 4), 2)


def test_standardised_training_tokens_have_unit_spread(speaker, fused_tokens):
    standard = speaker.model.projector.standardise(fused_tokens)
    torch.testing.assert_close(standard.mean(0), torch.zeros(standard.shape[1]), atol=1e-5, rtol=0)
    torch.testing.assert_close(standard.std(0, correction=0), torch.ones(standard.shape[1]))
