"""Bursts of loss agree with the closed forms of netem's models, and links are independent."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws, Seeds
from zenvoy.links.chains import Chains, Step
from zenvoy.links.loss import four_state, gilbert_elliott
from zenvoy.scenarios import FourState, GilbertElliott, ScenarioError, load

LINKS: Final = 1_000
FRAMES: Final = 1_000  # of each link: a million in all
SETTLING: Final = 300  # chains begin in the first state; closed forms hold in the long run
Z_99: Final = 2.576

GILBERT: Final = (
    GilbertElliott(p=0.05, r=0.25),
    GilbertElliott(p=0.1),  # r = 1 - p
    GilbertElliott(p=0.02, r=0.1, one_minus_h=0.7, one_minus_k=0.01),
)
STATES: Final = (
    FourState(p13=0.05, p31=0.3),
    FourState(p13=0.04, p31=0.2, p32=0.3, p23=0.4, p14=0.02),
    FourState(p13=0.1),  # p31 = 1 - p13
    FourState(p14=0.1),
)


def gilbert(model: GilbertElliott, seed: int) -> Step:
    return gilbert_elliott.step_of(model, Draws(Seeds((seed,), 1_000), gilbert_elliott.LOSS.number))


def four_states(model: FourState, seed: int) -> Step:
    return four_state.step_of(model, Draws(Seeds((seed,), 1_000), four_state.LOSS.number))


def losses(step: Step, links: int = LINKS, frames: int = FRAMES) -> NDArray[np.bool_]:
    """Return losses, (frames, links), of links to one receiver, once the chains have settled."""
    size = links + 1
    source, destination = np.arange(1, size), np.zeros(links, dtype=np.int64)
    chains = Chains(size, step)
    rows = [
        chains.lost(source, destination, np.full(links, sequence))
        for sequence in range(SETTLING + frames)
    ]
    return np.array(rows[SETTLING:])


def agrees(samples: NDArray[Any], value: float) -> bool:
    """Return whether `value` lies in the 99 % interval of the mean of independent samples."""
    error = samples.std(ddof=1) / np.sqrt(len(samples))
    return bool(abs(samples.mean() - value) <= Z_99 * error)


def burst_lengths(lost: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the lengths of all runs of lost frames that begin and end within the record."""
    lengths = []
    for column in lost.T:
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column.astype(np.int8), [0]])))
        begins, ends = edges[::2], edges[1::2]
        inside = (begins > 0) & (ends < len(column))
        lengths.append((ends - begins)[inside])
    return np.concatenate(lengths)


@pytest.mark.parametrize("model", GILBERT, ids=str)
def test_gilbert_elliott_loses_its_stationary_share(model: GilbertElliott) -> None:
    r = 1 - model.p if model.r is None else model.r
    bad = model.p / (model.p + r)
    share = bad * model.one_minus_h + (1 - bad) * model.one_minus_k
    assert agrees(losses(gilbert(model, 1)).mean(axis=0), share)


@pytest.mark.parametrize("model", GILBERT[:2], ids=str)
def test_bursts_of_gilbert_are_geometric(model: GilbertElliott) -> None:
    r = 1 - model.p if model.r is None else model.r
    lengths = burst_lengths(losses(gilbert(model, 2)))
    assert agrees(lengths, 1 / r)
    for length in (1, 2, 3):  # the whole distribution, not the mean alone
        assert agrees(lengths == length, r * (1 - r) ** (length - 1))


def test_losses_of_gilbert_have_the_correlation_of_its_eigenvalue() -> None:
    model = GilbertElliott(p=0.05, r=0.25)
    lost = losses(gilbert(model, 3)).astype(float)
    share = 0.05 / 0.30
    for lag in (1, 2, 5):
        product = ((lost[lag:] - share) * (lost[:-lag] - share)).mean(axis=0)
        assert agrees(product, share * (1 - share) * (1 - 0.05 - 0.25) ** lag)


@pytest.mark.parametrize("model", STATES, ids=str)
def test_four_states_lose_their_stationary_share_in_bursts_of_the_expected_length(
    model: FourState,
) -> None:
    p31 = 1 - model.p13 if model.p31 is None else model.p31
    lost = losses(four_states(model, 1))
    # Balance of the flows between states, in units of the share of state 1.
    in_burst = model.p13 / p31
    received_in_burst = in_burst * model.p32 / model.p23
    all_states = 1 + model.p14 + in_burst + received_in_burst
    assert agrees(lost.mean(axis=0), (model.p14 + in_burst) / all_states)
    bursts = model.p14 + model.p13 + received_in_burst * model.p23
    assert agrees(burst_lengths(lost), (model.p14 + in_burst) / bursts)


def test_two_of_the_four_states_are_gilberts_model() -> None:
    lost = losses(four_states(FourState(p13=0.05, p31=0.25), 4))
    assert agrees(lost.mean(axis=0), 0.05 / 0.30)
    assert agrees(burst_lengths(lost), 1 / 0.25)


def test_steps_have_the_order_of_netem() -> None:
    """Gilbert-Elliott loses by the state it leaves, the 4-state model by the one it reaches."""
    always = gilbert(GilbertElliott(p=1.0, r=1.0), 1)
    chains = Chains(2, always)
    one, other = np.array([0]), np.array([1])
    assert [bool(chains.lost(one, other, np.array([k]))[0]) for k in range(4)] == [
        False,
        True,
        False,
        True,
    ]
    chains = Chains(2, four_states(FourState(p13=1.0, p31=1.0), 1))
    assert [bool(chains.lost(one, other, np.array([k]))[0]) for k in range(4)] == [
        True,
        False,
        True,
        False,
    ]


def test_links_are_independent() -> None:
    lost = losses(gilbert(GilbertElliott(p=0.3, r=0.7), 5), links=20, frames=5_000)
    # p + r = 1: frames are independent in time too, so a correlation has deviation 1 / sqrt(n).
    between = np.asarray(np.corrcoef(lost.T))[np.triu_indices(20, 1)]
    assert np.abs(between).max() < 4.5 / np.sqrt(5_000)  # of 190 pairs, with confidence 99.9 %
    assert abs(between.mean()) < Z_99 / np.sqrt(5_000 * len(between))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            ("p13=0.6", "p14=0.5"),
            "channel.loss.four_state.p14: 0.5 and channel.loss.four_state.p13 (0.6)"
            " are more than 1 together",
        ),
        (
            ("p31=0.6", "p32=0.5"),
            "channel.loss.four_state.p32: 0.5 and channel.loss.four_state.p31 (0.6)"
            " are more than 1 together",
        ),
        (("p23=1.5",), "channel.loss.four_state.p23: 1.5 is not in [0, 1]"),
    ],
)
def test_impossible_states_are_refused(settings: tuple[str, ...], message: str) -> None:
    overrides = [f"channel.loss.four_state.{setting}" for setting in settings]
    with pytest.raises(ScenarioError) as refused:
        load("quickstart", overrides)
    assert message in str(refused.value)
