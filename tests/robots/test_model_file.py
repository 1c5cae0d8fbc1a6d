"""MJCF files that would take MuJoCo forever, or all memory."""

import os
import struct
from pathlib import Path

import pytest

from mpma_mj.envs.load import load
from mpma_mj.errors import BadOptionError
from mpma_mj.robots.model_file import read_model_file
from mpma_mj.sysid.model_file import write_model
from tests.envs.user_models import OURS, edited

END = "</worldbody>"
REPLICAS = '<replicate count="1000" euler="0 0 1">'


@pytest.fixture
def own(tmp_path: Path) -> Path:
    return tmp_path / "my_arms.xml"


def refused(path: Path) -> str:
    with pytest.raises(BadOptionError) as caught:
        read_model_file(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('timestep="0.005"', 'timestep="1e-12"', "timestep is 1e-12 s; expected 1e-05 to 1 s"),
        ('timestep="0.005"', 'timestep="nan"', "timestep is nan s; expected 1e-05 to 1 s"),
        ("<option ", '<option iterations="2000000000" ', "has 2,000,000,000 iterations"),
        ('memory="1M"', 'memory="900G"', "has 966,367,641,600 bytes of memory"),
        ("<asset>", '<asset><hfield name="h" nrow="100000" ncol="100000"/>', "cells, the last of"),
        ("<asset>", '<asset><texture name="t" width="99999" height="99999"/>', "by <texture>"),
        ("<asset>", '<asset><mesh name="m" builtin="plate" params="99999 99999"/>', "by <mesh>"),
        ("<worldbody>", '<size nkey="2000000000"/><worldbody>', "by <size>"),
        (END, f"{END}<sensor><user dim='2000000000'/></sensor>", "by <user>"),
        (END, f"<replicate count='1000000'><geom size='1'/></replicate>{END}", "has 1,000,"),
        (END, f"{REPLICAS * 2}<geom/>{'</replicate>' * 2}{END}", "elements; expected at most 10"),
        (END, f"<flexcomp name='f' count='300 300 300'/>{END}", "elements; expected at most 10"),
        (END, f"{'<body>' * 20_000}{'</body>' * 20_000}{END}", "elements; expected at most 10"),
        (END, f"{END}<include file='my_arms.xml'/>", "my_arms.xml in itself; leave that out"),
        ("<asset>", "<asset><model name='m' file='my_arms.xml'/>", "in itself; leave that out"),
        (OURS, f'<!DOCTYPE m [<!ENTITY a "aa">]>{OURS}', "declares a document type"),
        ('name="torso"', 'name="&#27;"', "is no MJCF file"),
    ],
)
def test_what_no_arms_need_is_refused_before_it_is_made(
    own: Path, old: str, new: str, problem: str
) -> None:
    assert problem in refused(edited(own, (old, new)))


def test_names_are_utf_8(own: Path) -> None:
    text = OURS.replace('name="torso"', 'name="torso\xff"').encode("latin-1")
    own.write_bytes(b'<?xml version="1.0" encoding="latin-1"?>' + text)
    assert "no XML in UTF-8" in refused(own)


@pytest.mark.parametrize(
    "element", ["<mesh", "<texture name='x' type='2d'", "<hfield name='x'", "<skin", "<model"]
)
@pytest.mark.parametrize("kind", ["pipe", "folder", "device", "MB"])
def test_files_that_a_model_names_are_files(own: Path, element: str, kind: str) -> None:
    other = own.parent / "meshes" / "other"
    other.parent.mkdir()
    name = "/dev/zero" if kind == "device" else "other"
    match kind:
        case "pipe":
            os.mkfifo(other)
        case "folder":
            other.mkdir()
        case "MB":
            with other.open("wb") as file:
                file.truncate(5_000_000_000)
    folders = ("<compiler", '<compiler meshdir="meshes"')
    edited(own, folders, ("<asset>", f"<asset>{element} file='{name}'/>"))
    assert kind in refused(own)


def test_a_model_includes_few_files_in_one_another(own: Path) -> None:
    for number in range(12):
        text = f"<mujoco><include file='{number + 1}.xml'/></mujoco>"
        own.with_name(f"{number}.xml").write_text(text)
    assert "has 11 files in one another" in refused(own.with_name("0.xml"))


def test_files_are_found_where_mujoco_strips_their_folders(own: Path) -> None:
    os.mkfifo(own.with_name("other.obj"))
    mesh = "<asset><mesh file='far/away/other.obj'/>"
    edited(own, ("<compiler", '<compiler strippath="true"'), ("<asset>", mesh))
    assert "is a pipe" in refused(own)


def test_a_picture_is_refused_by_its_size(own: Path) -> None:
    picture = own.with_name("picture.png")
    picture.write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + struct.pack(">II", 100_000, 100_000))
    edited(own, ("<asset>", "<asset><texture name='t' type='2d' file='picture.png'/>"))
    assert f"cells, the last of them by {picture}" in refused(own)


def test_attached_models_count_as_often_as_they_are_attached(own: Path) -> None:
    part = own.with_name("part.xml")
    bodies = "".join(f"<body name='b{number}'/>" for number in range(200))
    part.write_text(f"<mujoco><worldbody><body name='all'>{bodies}</body></worldbody></mujoco>")
    attach = f"{REPLICAS}<attach model='part' body='all' prefix='p'/></replicate>{END}"
    edited(own, ("<asset>", "<asset><model name='part' file='part.xml'/>"), (END, attach))
    assert "elements; expected at most 10,000" in refused(own)


def urdf(folder: Path) -> tuple[Path, Path]:
    """Write a URDF file that names a mesh of its package, which is two folders above."""
    path = folder / "my_robot" / "urdf" / "my.urdf"
    mesh = folder / "my_robot" / "meshes" / "cube.obj"
    path.parent.mkdir(parents=True)
    mesh.parent.mkdir()
    path.write_text(
        '<robot name="r"><link name="a"><collision><geometry>'
        '<mesh filename="package://my_robot/meshes/cube.obj"/>'
        "</geometry></collision></link></robot>"
    )
    return path, mesh


def test_a_mesh_of_a_ros_package_is_found(tmp_path: Path) -> None:
    path, mesh = urdf(tmp_path)
    vertices = "".join(f"v {n & 1} {n >> 1 & 1} {n >> 2}\n" for n in range(8))
    mesh.write_text(f"{vertices}f 1 2 3\nf 4 5 6\nf 6 7 8\n")
    assert read_model_file(path).compile().nmesh == 1


def test_a_mesh_of_a_ros_package_is_a_file(tmp_path: Path) -> None:
    path, mesh = urdf(tmp_path)
    os.mkfifo(mesh)
    assert "is a pipe" in refused(path)


@pytest.mark.parametrize("kind", ["missing", "pipe", "device"])
def test_a_model_is_a_file(own: Path, kind: str) -> None:
    if kind == "pipe":
        os.mkfifo(own)
    path = Path("/dev/zero") if kind == "device" else own
    expected = "no such file" if kind == "missing" else f"is a {kind}"
    with pytest.raises(BadOptionError, match=expected):
        load("ymca", robot=path)
    with pytest.raises(BadOptionError, match=expected):
        write_model(own.with_name("new.xml"), {}, path)
