"""A closed set of answers as one tree of tokens: what several begin with alike is read once.

Of ten answers about direction it leaves 63 of 100 places to read, of twenty that confirm or deny
115 of 260, all in one row: no copies of the prompt's keys and values are made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class AnswerTree:
    """Tokens that follow a prompt, and how each answer runs through them.

    Nodes hold every token of every answer but its last, after which nothing is asked; a node comes
    after the one it continues.

    Args:
        ids: Token of each node, (1, nodes).
        depths: How many tokens of the answer precede it, (1, nodes).
        sees: True where a node (row) may look at another (column), itself included, (nodes, nodes).
        answers: Tokens of each answer, (answers, longest), padded with zeros on the right.
        asked_at: Where each of those tokens is predicted, same shape: 0 after the prompt, n + 1
            after node n.
        is_token: False at the padding, same shape.
    """

    ids: Tensor
    depths: Tensor
    sees: Tensor
    answers: Tensor
    asked_at: Tensor
    is_token: Tensor

    @classmethod
    def of(cls, answers: Sequence[Sequence[int]]) -> AnswerTree:
        """Build the tree of some answers.

        Args:
            answers: Tokens of each, their end included.

        Raises:
            ValueError: If there is no answer or one is empty.
        """
        if not answers or not all(answers):
            raise ValueError("an answer tree needs answers of one token or more")
        nodes: dict[tuple[int, ...], int] = {}
        for answer in answers:
            for end in range(1, len(answer)):
                nodes.setdefault(tuple(answer[:end]), len(nodes))
        sees = torch.eye(len(nodes), dtype=torch.bool)
        for start, place in nodes.items():
            if len(start) > 1:
                sees[place] |= sees[nodes[start[:-1]]]
        longest = max(map(len, answers))
        ids, asked_at = torch.zeros(2, len(answers), longest, dtype=torch.long)
        for row, answer in enumerate(answers):
            ids[row, : len(answer)] = torch.tensor(answer)
            for place in range(1, len(answer)):
                asked_at[row, place] = nodes[tuple(answer[:place])] + 1
        lengths = torch.tensor([len(answer) for answer in answers])
        return cls(
            ids=torch.tensor([[start[-1] for start in nodes]], dtype=torch.long),
            depths=torch.tensor([[len(start) - 1 for start in nodes]], dtype=torch.long),
            sees=sees,
            answers=ids,
            asked_at=asked_at,
            is_token=torch.arange(longest) < lengths[:, None],
        )

    def log_likelihoods(self, log_probabilities: Tensor) -> Tensor:
        """Return the log-probability of each answer as a whole, (answers,).

        Args:
            log_probabilities: Of every token after the prompt and after each node, (1 + nodes,
                vocabulary).
        """
        own = log_probabilities[self.asked_at, self.answers]
        return own.where(self.is_token, 0.0).sum(dim=1)
