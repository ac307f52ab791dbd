"""Expected values: a small tree written out by hand, and sums over each answer's own tokens."""

import pytest
import torch

from geotlm_lm.language.answer_tree import AnswerTree

ANSWERS = [[5, 6, 9], [5, 7, 6, 9], [8, 9], [5, 6, 7, 9]]


def test_common_beginnings_are_one_node():
    tree = AnswerTree.of(ANSWERS)
    assert tree.ids.tolist() == [[5, 6, 7, 6, 8, 7]]
    assert tree.depths.tolist() == [[0, 1, 1, 2, 0, 2]]
    sees = [row.nonzero().flatten().tolist() for row in tree.sees]
    assert sees == [[0], [0, 1], [0, 2], [0, 2, 3], [4], [0, 1, 5]]


def steps(nodes):
    torch.manual_seed(0)
    return torch.randn(1 + nodes, 12).log_softmax(-1)


def test_a_likelihood_is_the_product_along_the_way():
    said = steps(6)
    found = AnswerTree.of(ANSWERS).log_likelihoods(said)
    ways = [[0, 1, 2], [0, 1, 3, 4], [0, 5], [0, 1, 2, 6]]
    expected = [
        sum(float(said[place, token]) for place, token in zip(way, answer, strict=True))
        for way, answer in zip(ways, ANSWERS, strict=True)
    ]
    assert found.tolist() == pytest.approx(expected)


@pytest.mark.parametrize("which", range(len(ANSWERS)))
def test_the_answer_of_likeliest_tokens_is_followed(which):
    tree, said = AnswerTree.of(ANSWERS), steps(6)
    for place, token in zip(tree.asked_at[which], tree.answers[which], strict=True):
        if token:
            said[place, token] = 1.0
    assert tree.followed(said) == which


def test_other_words_follow_no_answer():
    said = steps(6)
    said[:, 11] = 1.0
    assert AnswerTree.of(ANSWERS).followed(said) is None


def test_an_answer_of_its_end_alone_needs_no_node():
    tree, said = AnswerTree.of([[9]]), steps(0)
    assert tree.ids.shape == (1, 0)
    assert tree.log_likelihoods(said).tolist() == pytest.approx([float(said[0, 9])])


@pytest.mark.parametrize("answers", [[], [[5, 9], []]])
def test_nothing_to_weigh_is_refused(answers):
    with pytest.raises(ValueError, match="answers of one token or more"):
        AnswerTree.of(answers)
