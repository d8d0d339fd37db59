"""How evenly a topic was sampled is measured from its stamps."""

import numpy as np
import pytest

from test.recording.bags import motion, write_bag
from trunk_ros.recording.quality import quality, quality_of
from trunk_ros.recording.read import read_recording


def test_an_even_topic_has_its_rate_and_no_loss():
    seen = quality_of(np.arange(1000) / 100)
    assert seen.rate == pytest.approx(100)
    assert (seen.lost, seen.gaps, seen.expected) == (0, 0, 1000)
    assert seen.jitter == pytest.approx(0, abs=1e-9)


def test_losses_are_counted_and_the_longest_gap_is_found():
    stamp = np.delete(np.arange(1000) / 100, [*range(300, 340), 700, 800])
    seen = quality_of(stamp)
    assert (seen.lost, seen.expected, seen.gaps) == (42, 1000, 1)
    assert (seen.longest_gap, seen.gap_at) == (pytest.approx(0.41), pytest.approx(2.99))


def test_jitter_is_measured_and_is_no_loss():
    random = np.random.default_rng(1)
    seen = quality_of(np.arange(5000) / 100 + random.normal(scale=5e-4, size=5000))
    assert seen.jitter == pytest.approx(5e-4 * np.sqrt(2), rel=0.1)
    assert seen.lost == 0


def test_of_an_uneven_topic_nothing_is_expected():
    random = np.random.default_rng(1)
    seen = quality_of(np.cumsum(random.uniform(0.3, 1.2, 500)))
    assert (seen.lost, seen.expected, seen.gaps) == (None, None, 0)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_few_samples_are_no_trouble(count):
    assert quality_of(np.arange(count, dtype=float)).samples == count


def test_the_quality_of_a_recording_has_what_the_reader_counted(tmp_path):
    messages = motion()
    messages += messages[:3]
    seen = quality(read_recording(write_bag(tmp_path / "bag", messages)))["joint_states"]
    assert (seen.messages, seen.samples, seen.duplicates) == (53, 50, 3)
