"""Registration with Gymnasium."""

import subprocess
import sys
from typing import Any

import gymnasium
import pytest

from mpma_mj.envs.gym_env import FlatImitationEnv, ImitationEnv
from mpma_mj.envs.vector_env import FlatVectorImitationEnv, VectorImitationEnv
from tests.envs.test_gl import python

DICTIONARY, FLAT = NAMES = ("TwoArmImitation-v0", "TwoArmImitationFlat-v0")


def make(name: str = DICTIONARY, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(f"mpma_mj:{name}", **{"repeats": 1, **options})


def test_registered_in_whichever_order_packages_are_imported() -> None:
    made = "gymnasium.make('mpma_mj:TwoArmImitation-v0', disable_env_checker=True)"
    for first in ("import gymnasium", "import mpma_mj; import gymnasium"):
        result = subprocess.run(
            [sys.executable, "-W", "error::UserWarning", "-c", f"{first}; print({made})"],
            capture_output=True,
            text=True,
            check=False,
        )
        assert "ImitationEnv<TwoArmImitation-v0>" in result.stdout, result.stderr


def test_registering_does_not_import_mujoco() -> None:
    code = "import mpma_mj, gymnasium, sys; print({'mujoco'} & set(sys.modules))"
    assert python(code).stdout.strip() == "set()"


def test_each_id_makes_its_class() -> None:
    assert type(make(DICTIONARY).unwrapped) is ImitationEnv
    assert type(make(FLAT).unwrapped) is FlatImitationEnv


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("TwoArmImitation-v0", VectorImitationEnv),
        ("TwoArmImitationFlat-v0", FlatVectorImitationEnv),
    ],
)
def test_gymnasium_makes_vectors(name: str, kind: type) -> None:
    envs = gymnasium.make_vec(f"mpma_mj:{name}", num_envs=2, motion="ymca", arms="kinematic")
    assert type(envs.unwrapped) is kind
    envs.reset(seed=1)
    envs.step(envs.action_space.sample())
    envs.close()
