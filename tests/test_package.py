"""What is shipped: wheel and sdist carry the model and work in a clean environment."""

import subprocess
import sys
import sysconfig
import tarfile
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

LOAD = (
    "import mpma_mj, pathlib; "
    "assert mpma_mj.load('ymca').reset().first(); "
    "print(pathlib.Path(mpma_mj.__file__).parent)"
)


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with wheel and sdist, each built from this checkout."""
    folder = tmp_path_factory.mktemp("dist")
    build(ROOT, folder, "--wheel", "--sdist")
    return folder


def build(source: Path, folder: Path, *options: str) -> None:
    command = [sys.executable, "-m", "build", "--no-isolation", *options, "--outdir", folder]
    built = subprocess.run([*command, source], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr


def install(
    distribution: Path, folder: Path, *, with_dependencies: bool
) -> subprocess.CompletedProcess[str]:
    """Install into a new environment and load the package's environment there."""
    venv.create(folder)
    python = folder / "bin" / "python"
    options = [] if with_dependencies else ["--no-deps"]
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", *options]
    installed = subprocess.run(
        [*pip, str(distribution)], capture_output=True, text=True, check=False
    )
    assert installed.returncode == 0, installed.stderr
    if not with_dependencies:
        # Borrow the libraries of this environment, but not its links to this checkout.
        site = next(folder.glob("lib/python*/site-packages"))
        (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return subprocess.run(
        [python, "-I", "-c", LOAD], capture_output=True, text=True, check=False, cwd=folder
    )


@pytest.mark.parametrize("pattern", ["*.whl", "*.tar.gz"])
def test_distributions_load_an_environment(
    distributions: Path, pattern: str, tmp_path: Path
) -> None:
    distribution = next(distributions.glob(pattern))
    if pattern == "*.tar.gz":
        with tarfile.open(distribution) as archive:
            archive.extractall(tmp_path, filter="data")
        build(next(tmp_path.glob("mpma_mj-*")), tmp_path, "--wheel")
        distribution = next(tmp_path.glob("*.whl"))
    loaded = install(distribution, tmp_path / "clean", with_dependencies=False)
    assert loaded.returncode == 0, loaded.stderr
    assert str(tmp_path) in loaded.stdout


@pytest.mark.slow
@pytest.mark.parametrize("pattern", ["*.whl", "*.tar.gz"])
def test_distributions_bring_their_dependencies(
    distributions: Path, pattern: str, tmp_path: Path
) -> None:
    distribution = next(distributions.glob(pattern))
    loaded = install(distribution, tmp_path / "clean", with_dependencies=True)
    assert loaded.returncode == 0, loaded.stderr
    assert str(tmp_path) in loaded.stdout


@pytest.mark.slow
def test_the_lowest_declared_versions_train(distributions: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "lowest")
    binaries = tmp_path / "lowest" / "bin"
    uv = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--python", binaries / "python"]
    wheel = next(distributions.glob("*.whl"))
    subprocess.run([*uv, "--resolution", "lowest-direct", wheel], check=True)
    options = ["--nodes", "5", "--epochs", "1", "--no-video", "--out", tmp_path / "run"]
    trained = subprocess.run(
        [binaries / "mpma", "imitate", "ymca", *options],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert trained.returncode == 0, trained.stderr
    assert trained.stdout.splitlines()[-1] == str(tmp_path / "run")


@pytest.mark.parametrize("part", ["assets", "envs", "training"])
def test_the_top_level_shows_the_parts(part: str) -> None:
    link = ROOT / part
    assert link.is_symlink()
    assert not link.readlink().is_absolute()
    assert link.resolve() == (ROOT / "mpma_mj" / part).resolve()
