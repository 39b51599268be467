"""The models in a section of loss add up, and loss depends on link and frame alone."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.channel.loss import Losses
from zenvoy.keyed_random.draws import Seeds
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import FourState, GilbertElliott, Loss

BOTH: Final = Loss(
    gilbert_elliott=GilbertElliott(p=0.2, r=0.4, one_minus_h=0.9),
    four_state=FourState(p13=0.1, p31=0.3, p14=0.05),
)


Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


def lost(losses: Losses, source: Ints, destination: Ints, sequence: Ints) -> Bools:
    """Return which frames a section loses although their draw would let them through."""
    frames = SentFrames(source, destination, np.full(len(source), 50.0), sequence)
    scene = Scene(int(sequence[0]), 0, np.zeros(0), None)
    return losses.lost(frames, scene, np.full(len(source), 1.0 - 2.0**-53))


@given(seed=st.integers(0, 2**63 - 1), heard=st.lists(st.booleans(), min_size=30, max_size=30))
def test_loss_depends_on_link_and_frame_alone(seed: int, heard: list[bool]) -> None:
    """Time out of range and other links do not change it."""
    everyone, alone = Losses(BOTH, Seeds((seed,), 4)), Losses(BOTH, Seeds((seed,), 4))
    source, destination = np.array([0, 1, 2, 2]), np.array([1, 2, 1, 3])
    for sequence, hears in enumerate(heard):
        all_of_them = lost(everyone, source, destination, np.full(4, sequence))
        if hears:
            one = lost(alone, source[2:3], destination[2:3], np.array([sequence]))
            assert one[0] == all_of_them[2]


def test_an_empty_section_loses_nothing() -> None:
    assert not lost(Losses(Loss(), Seeds((1,), 2)), *(np.array([k]) for k in (0, 1, 0))).any()
    assert not Losses(Loss(), Seeds((1,), 2)).draws
    assert not Losses(BOTH, Seeds((1,), 2)).draws  # bursts draw for themselves


@pytest.mark.parametrize("loss", [Loss(p=0.5), Loss(by_distance=((0.0, 0.5),))])
def test_chances_are_compared_with_the_draw(loss: Loss) -> None:
    losses = Losses(loss, Seeds((1,), 4))
    assert losses.draws
    sender, sequence = np.array([0, 1, 2]), np.zeros(3, dtype=np.int64)
    frames = SentFrames(sender, sender + 1, np.full(3, 50.0), sequence)
    found = losses.lost(frames, Scene(0, 0, np.zeros(4), None), np.array([0.0, 0.49, 0.5]))
    assert found.tolist() == [True, True, False]


def test_a_frame_is_lost_if_any_model_loses_it() -> None:
    index = np.arange(1, 500), np.zeros(499, dtype=np.int64), np.full(499, 7)
    one, other, together = (
        lost(Losses(loss, Seeds((1,), 500)), *index)
        for loss in (
            Loss(gilbert_elliott=BOTH.gilbert_elliott),
            Loss(four_state=BOTH.four_state),
            BOTH,
        )
    )
    np.testing.assert_array_equal(together, one | other)
    assert 0 < together.sum() < 499
