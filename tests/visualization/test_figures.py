"""Figures, strip and video: that they show what they should, not their exact pixels."""

import itertools
from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.transforms import Bbox

from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.kinematics import posture_from_angles
from mpma_mj.motions import ymca
from mpma_mj.trace import Trace
from mpma_mj.training.run_folder import RunFolder
from mpma_mj.visualization.colours import hex_to_rgb, module_colours
from mpma_mj.visualization.figures import write_figures
from mpma_mj.visualization.responsibility_strip import Strip, label_runs
from mpma_mj.visualization.scene import Scene
from mpma_mj.visualization.video import episode_frames, write_video

LABELS = ("Y", "M", "C", "A")
CONTEXT = np.repeat(np.eye(4), 10, axis=0)


def test_runs_of_labels() -> None:
    context = np.eye(3)[[0, 0, 1, 1, 1, 0]]
    assert label_runs(context) == [(0, 0, 2), (1, 2, 5), (0, 5, 6)]


def test_a_figure_a_file_and_nothing_else(small_run: Path, tmp_path: Path) -> None:
    folder = RunFolder(small_run)
    write_figures(tmp_path, folder.read_trace(), folder.read_motion())
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"responsibility.png", "module_output.png", "trajectory.png"}
    for name in names:
        assert iio.imread(tmp_path / name).std() > 10


def test_rows_are_named_by_module_and_by_plant_where_there_are_several(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = RunFolder(small_run)
    trace, motion = folder.read_trace(), folder.read_motion()
    modules = trace.with_modules().map(lambda signal: np.repeat(signal[:, :2], 2, axis=1) / 2)
    names: list[str] = []
    monkeypatch.setattr(Axes, "set_ylabel", lambda _, name, **__: names.append(name))
    write_figures(tmp_path, replace(trace, modules=modules), motion)
    one_plant = [f"module {i}" for i in (1, 2, 3, 4)]
    assert names[-4:] == one_plant
    write_figures(tmp_path, replace(trace, modules=modules), motion, plants=2)
    two_plants = ["module 1\nplant 1", "module 2\nplant 1", "module 3\nplant 2"]
    assert names[-4:] == [*two_plants, "module 4\nplant 2"]


@pytest.mark.parametrize(
    ("length", "plants", "font_size"), [(1, 1, 10.0), (60, 1, 7.0), (60, 2, 11.0)]
)
def test_no_text_is_cut_off_or_lies_over_another(
    length: int,
    plants: int,
    font_size: float,
    small_run: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = RunFolder(small_run)
    trace, motion = folder.read_trace(), folder.read_motion()
    motion = replace(motion, labels=tuple(length * label for label in LABELS), name=length * "dan")
    checked: list[FigureCanvasAgg] = []
    save = FigureCanvasAgg.print_png

    def look(canvas: FigureCanvasAgg, path: Path) -> None:
        save(canvas, path)
        (legend,), axes = canvas.figure.legends, canvas.figure.axes
        whole = Bbox.union([part.get_tightbbox() for part in (*axes, legend)])
        assert min(whole.x0, whole.y0) >= 0
        assert (canvas.get_width_height() >= whole.max).all()
        texts = [*axes[0].texts, axes[0].title, axes[-1].xaxis.label, legend]
        boxes = [text.get_window_extent() for text in texts]
        assert len(boxes) > 4
        assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))
        checked.append(canvas)

    monkeypatch.setattr(FigureCanvasAgg, "print_png", look)
    with matplotlib.rc_context({"font.size": font_size}):
        write_figures(tmp_path, trace, motion, plants=plants)
    assert len(checked) == 3


def test_the_strip_has_the_colour_of_the_responsible_module() -> None:
    strip = Strip(CONTEXT[:, [1, 0, 2, 3]], CONTEXT, LABELS, LABELS)
    frame = strip.under(np.full((480, 640, 3), 200, np.uint8), 39)
    assert frame.shape == (576, 640, 3)
    middle = frame[480 + 50]
    for label, module in enumerate([1, 0, 2, 3]):
        expected = hex_to_rgb(module_colours(4)[module])
        np.testing.assert_array_equal(middle[80 + 160 * label], expected)


def test_equal_shares_have_bands_of_equal_height() -> None:
    strip = Strip(np.full((40, 4), 0.25), CONTEXT, LABELS, LABELS)
    column = strip.under(np.zeros((480, 640, 3), np.uint8), 39)[480 + 22 : -18, 80]
    colours, counts = np.unique(column, axis=0, return_counts=True)
    assert len(colours) == 4
    assert counts.max() - counts.min() <= 1


def test_the_mark_moves_with_time_and_the_letter_with_the_label() -> None:
    strip = Strip(CONTEXT, CONTEXT, LABELS, LABELS)
    picture = np.full((480, 640, 3), 200, np.uint8)
    first, later = strip.under(picture, 0), strip.under(picture, 20)
    assert (first[:480] != later[:480]).any()
    changed = np.flatnonzero((first[480:] != later[480:]).any(axis=(0, 2)))
    assert changed.min() < 16
    assert 320 <= changed.max() < 336
    assert (picture == 200).all()


@pytest.mark.usefixtures("opengl")
def test_frames_show_arms_ghost_and_side(small_run: Path) -> None:
    folder = RunFolder(small_run)
    trace, motion = folder.read_trace(), folder.read_motion()
    trace = Trace.from_arrays({name: signal[:3] for name, signal in trace.to_arrays().items()})

    def first(camera: str = "front", **changes: np.ndarray) -> np.ndarray:
        scene = Scene(replace(trace, **changes), motion, camera=camera)
        return next(episode_frames(scene))[:480].astype(int)

    assert np.abs(first() - first("side")).mean() > 3
    elsewhere = trace.reference * np.tile([1, 1, -1], 4)
    assert (first() != first(reference=elsewhere)).any(axis=2).mean() > 0.003
    danced = posture_from_angles(trace.joint_angles * 0.2)
    assert (first() != first(posture=danced)).any(axis=2).mean() > 0.01
    noise = np.random.default_rng(0).normal(0.0, 0.1, trace.joint_angles.shape)
    noisy = first(joint_angles=trace.joint_angles + noise)
    assert np.abs(first() - noisy).max() <= 1  # of 255


@pytest.mark.usefixtures("opengl")
def test_the_video_shows_every_step_at_the_speed_of_the_dance(
    small_run: Path, tmp_path: Path
) -> None:
    folder, path = RunFolder(small_run), tmp_path / "dance.mp4"
    counted: list[int] = []

    def progress(steps: range) -> range:
        counted.append(len(steps))
        return steps

    write_video(path, Scene(folder.read_trace(), folder.read_motion()), progress)
    properties = iio.immeta(path)
    assert properties["fps"] == 20.0
    assert properties["size"] == (640, 576)
    assert counted == [3 * len(ymca()) - 1]
    assert properties["duration"] == pytest.approx(counted[0] / 20.0, abs=0.1)
    frame = iio.imread(path, index=40)
    assert frame.std() > 20
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.usefixtures("opengl")
def test_frames_show_the_plant_that_is_on(small_run: Path) -> None:
    folder = RunFolder(small_run)
    arrays, motion = folder.read_trace().to_arrays(), folder.read_motion()
    options = EnvironmentOptions(plants=({}, {"payload": 20.0}))  # type: ignore[arg-type]
    drawn = []
    for plant in (0, 1):
        plants = np.full(len(arrays["action"]), plant)
        trace = Trace.from_arrays(arrays | {"plant": plants})
        drawn.append(next(episode_frames(Scene(trace, motion, options, size=(160, 216)))))
    assert not np.array_equal(*drawn)
