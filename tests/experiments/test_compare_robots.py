"""The comparison of robots."""

import csv
import dataclasses

import numpy as np
import pytest

from mpma_mj.errors import BadOptionError
from mpma_mj.experiments.backend import open_backend
from mpma_mj.experiments.compare_robots import OnRobot, compare_robots, robot_jobs
from mpma_mj.experiments.compare_robots_report import as_csv, as_markdown, first_episodes
from mpma_mj.robots.robot_file import CATALOGUE
from mpma_mj.training.config import RunConfig

ROBOTS = ("two_arm", "cmu_humanoid")
SMALL = RunConfig.of(nodes=20, modules=2, repeats=1)


@pytest.fixture(scope="module")
def results() -> list[OnRobot]:
    with pytest.warns(match="cmu_humanoid has joints and speeds of its own"):
        jobs = robot_jobs(SMALL, ROBOTS, runs=2, epochs=3)
    return [job.do() for job in jobs]


def test_every_robot_has_its_own_motion_and_agents(results: list[OnRobot]) -> None:
    assert [one.robot.name for one in results] == list(ROBOTS)
    assert [len(one.episodes) for one in results] == [2, 2]
    assert [one.motion.angles_of.split()[0] for one in results] == list(ROBOTS)
    for one in results:
        assert min(one.feedback) > 3.0 * max(one.values("p_e_percent"))
        assert all(0.1 < share <= 1.3 for share in one.values("speed_share"))


def test_what_is_unavoidable_is_not_what_agents_reach(results: list[OnRobot]) -> None:
    own, other = results
    assert own.reach.feasible == own.reach.reachable == 1.0
    assert own.reach.unavoidable < 1e-9
    assert 0.8 < other.reach.feasible <= other.reach.reachable < 1.0
    assert min(other.values("p_e_percent")) > other.reach.unavoidable > 0.05


def test_weight_costs_torque_within_the_limits(results: list[OnRobot]) -> None:
    for one in results:
        assert min(one.values("mean_torque_nm")) > 0.5
        assert all(0.0 < share < 0.5 for share in one.values("torque_share"))


def test_ideal_arms_and_late_commands_have_no_torque() -> None:
    for option in ({"arms": "kinematic"}, {"latency": 1}):
        (job,) = robot_jobs(SMALL.replace(**option), ["two_arm"], runs=1, epochs=2)
        done = job.do()
        assert done.values("mean_torque_nm") == done.values("torque_share") == []
        assert len(done.values("speed_share")) == 1


@pytest.mark.filterwarnings("ignore:ymca")
def test_workers_bring_the_same_in_the_order_of_the_robots(results: list[OnRobot]) -> None:
    with open_backend("processes", 2, None) as backend:
        found = compare_robots(robot_jobs(SMALL, ROBOTS, runs=2, epochs=3), backend)
    assert as_csv(found) == as_csv(results)
    assert as_markdown(found) == as_markdown(results)


def test_tables_keep_what_a_robot_can_do_apart_from_what_agents_learn(
    results: list[OnRobot],
) -> None:
    demands, agents, robots, *notes = as_markdown(results).split("\n\n")
    head = "| robot | reachable, % | feasible, % | unavoidable p_e, % |"
    assert demands.splitlines()[0] == head
    assert demands.splitlines()[2] == "| two_arm | 100.0 | 100.0 | 0.00 |"
    assert agents.splitlines()[0].startswith("| robot | epochs | p_e, % |")
    assert "| cmu_humanoid | CMU humanoid of dm_control | 12, 20, 12, 15 | Apache" in robots
    assert notes[-1] == "Means over 2 seeds, of p_e with 95 % bootstrap intervals.\n"
    rows = list(csv.DictReader(as_csv(results).splitlines()))
    assert [row["robot"] for row in rows] == ["two_arm"] * 2 + ["cmu_humanoid"] * 2
    last = results[-1].episodes[1]
    assert last is not None
    assert float(rows[-1]["p_e_percent"]) == last.measures["p_e_percent"]


def test_an_episode_that_diverged_counts_in_no_mean(results: list[OnRobot]) -> None:
    own, other = results
    lost = dataclasses.replace(
        other, episodes=(None, other.episodes[1]), feedback=np.array([np.nan, 2.0])
    )
    assert "1 of 4 episodes diverged; they count in no mean." in as_markdown([own, lost])
    assert list(first_episodes([own, lost])) == [own.robot.title]
    row = list(csv.DictReader(as_csv([own, lost]).splitlines()))[2]
    assert row["p_e_percent"] == row["feedback_alone_p_e_percent"] == ""
    none = dataclasses.replace(other, episodes=(None, None), feedback=np.full(2, np.nan))
    assert "| cmu_humanoid | 3.0 | – | – | – |" in as_markdown([none])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"robot": "h1"}, "robot is for one robot, but several are compared"),
        ({"locked_joint": "left_elbow"}, "locked_joint is a joint of one robot"),
        ({"plants": ({"payload": 1.0}, {})}, "robots are compared, each without plants"),
        ({"payload": (0.0, 1.0)}, "expected one number, as robots are compared"),
        ({"tempo": "auto"}, "tempo auto is another tempo for each robot"),
        ({"agent": "open_loop"}, "expected an agent that learns"),
    ],
)
def test_options_that_mean_something_else_on_each_robot_are_refused(
    options: dict[str, object], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        robot_jobs(SMALL.replace(**options), ROBOTS, runs=1, epochs=1)


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        (["two_arm", "cmu_humanoit"], "robots is 'cmu_humanoit'; .*cmu_humanoid"),
        (["two_arm", str(CATALOGUE / "two_arm.toml")], "robot two_arm is given twice"),
        (["two_arm", "two_arm"], "robot two_arm is given twice; give robots once each"),
        (["two_arm", "gone.toml"], "gone.toml: no such file"),
    ],
)
def test_robots_that_do_not_exist_or_come_twice_are_refused(
    robots: list[str], message: str
) -> None:
    with pytest.raises(BadOptionError, match=message):
        robot_jobs(SMALL, robots, runs=1, epochs=1)
