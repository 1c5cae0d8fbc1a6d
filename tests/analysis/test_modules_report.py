import numpy as np

from mpma_mj.analysis.modules_report import joint_terms


def test_a_synergy_is_named_by_the_joints_that_make_it_up_the_strongest_first() -> None:
    pattern = np.zeros(16)
    pattern[[0, 8 + 7, 1]] = [0.6, 0.78, 0.1]
    assert joint_terms(pattern) == ["-right elbow", "+left abduction"]


def test_a_synergy_of_one_joint_has_one_name() -> None:
    assert joint_terms(np.eye(16)[6]) == ["+right rotation"]


def test_a_synergy_of_all_joints_alike_names_what_makes_up_four_fifths() -> None:
    assert len(joint_terms(np.full(16, 0.25))) == 13
