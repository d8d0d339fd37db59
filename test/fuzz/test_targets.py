"""What the fuzzer begins with is read, by the readers that it fuzzes; what has broken one is read since."""

from __future__ import annotations

import random

import pytest

from test.fuzz.targets import TARGETS, attempt


@pytest.mark.parametrize("name", TARGETS)
def test_every_reader_reads_its_first_inputs_and_survives_mutations(name):
    target, chance = TARGETS[name], random.Random(name)
    for seed in target.seeds():
        target.read(seed)
        for _ in range(20):
            data = bytearray(seed)
            for _ in range(chance.choice((1, 3, 30))):
                data[chance.randrange(len(data))] = chance.choice((0, 255, chance.randrange(256)))
            attempt(target, bytes(data[: chance.choice((len(data), chance.randrange(len(data))))]))
