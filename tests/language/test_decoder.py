import numpy as np
import pytest
import torch

from geotlm_lm.language.sequence import SequenceDecoder, log_softmax


def ids_of(speaker, length=11):
    head = [speaker.prompts.tactile_id] * speaker.model.size.tactile_tokens
    tail = torch.randint(5, 400, (length,), generator=torch.Generator().manual_seed(1)).tolist()
    return torch.tensor([head + tail])


def test_a_later_token_changes_nothing_before_it(speaker, fused_tokens):
    model, ids = speaker.model, ids_of(speaker)
    other = ids.clone()
    other[0, -1] = 401
    prefix = model.projector(fused_tokens[:1])
    one, two = (model.decoder(model.embed(x, prefix)) for x in (ids, other))
    torch.testing.assert_close(one[:, :-1], two[:, :-1], rtol=0, atol=1e-6)
    assert not torch.allclose(one[:, -1], two[:, -1])


def test_standardised_training_tokens_have_unit_spread(speaker, fused_tokens):
    standard = speaker.model.projector.standardise(fused_tokens)
    torch.testing.assert_close(standard.mean(0), torch.zeros(standard.shape[1]), atol=1e-5, rtol=0)
    torch.testing.assert_close(standard.std(0, correction=0), torch.ones(standard.shape[1]))


@pytest.mark.parametrize("both_ways", [False, True])
def test_one_text_in_numpy_has_the_hidden_states_of_torch(speaker, both_ways):
    decoder, ids = speaker.model.decoder, ids_of(speaker)
    count = ids.shape[1]
    mask = torch.ones(1, 1, count, count, dtype=torch.bool) if both_ways else None
    with torch.no_grad():
        wanted = decoder(decoder.embed_tokens(ids), mask)[0]
        logits = torch.nn.functional.linear(wanted, decoder.embed_tokens.weight)
    plain = SequenceDecoder(decoder)
    x = plain.embeddings[ids[0].tolist()]
    found = plain.read(x, plain.started(count), both_ways=both_ways)
    np.testing.assert_allclose(found, wanted, rtol=1e-5, atol=1e-5)
    told = log_softmax(plain.logits(found))
    np.testing.assert_allclose(told, logits.log_softmax(-1), rtol=1e-4, atol=1e-4)


def test_a_text_in_numpy_is_read_on_token_by_token_and_again_from_where_it_was_cut(speaker):
    plain = SequenceDecoder(speaker.model.decoder)
    x = plain.embeddings[ids_of(speaker)[0].tolist()]
    whole = plain.read(x, plain.started(len(x)))
    cache = plain.started(len(x))
    plain.read(x[:9], cache)
    plain.read(x[:3], cache)
    cache.length = 9
    rest = [plain.read(one[None], cache)[0] for one in x[9:-2]]
    found = np.concatenate([rest, plain.read(x[-2:], cache)])
    np.testing.assert_allclose(found, whole[9:], rtol=1e-5, atol=1e-5)
