import numpy as np

from mpma_mj.utils.seeding import stream


def test_same_name_same_numbers() -> None:
    np.testing.assert_array_equal(stream(3, "a", 1).random(5), stream(3, "a", 1).random(5))


def test_other_names_and_seeds_other_numbers() -> None:
    paths = [(0, "a"), (1, "a"), (0, "b"), (0, "a", 0), (0, "a", 1), (0, "a", "b")]
    drawn = {tuple(stream(*path).random(3)) for path in paths}
    assert len(drawn) == len(paths)


def test_seed_zero_is_a_seed() -> None:
    assert stream(0, "x").random() == stream(0, "x").random()
