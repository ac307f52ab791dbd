import torch


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


def test_standardised_training_tokens_have_unit_spread(speaker, fused_tokens):
    standard = speaker.model.projector.standardise(fused_tokens)
    torch.testing.assert_close(standard.mean(0), torch.zeros(standard.shape[1]), atol=1e-5, rtol=0)
    torch.testing.assert_close(standard.std(0, correction=0), torch.ones(standard.shape[1]))
