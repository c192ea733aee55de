"""`colcon build` of the same folders, as a user of a native ROS 2 runs it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The checkout, built with colcon against the venv's ROS, in a folder of its own."""
    folder = tmp_path_factory.mktemp("workspace")
    environment = os.environ | {
        "PATH": f"{sys.prefix}/bin:{os.environ['PATH']}",
        "VIRTUAL_ENV": sys.prefix,
        "CMAKE_PREFIX_PATH": sys.prefix,
        "AMENT_PREFIX_PATH": sys.prefix,
    }
    result = subprocess.run(
        # Without optimisation, which is most of the compiler's time.
        [
            "colcon",
            "--log-base",
            "log",
            "build",
            "--base-paths",
            ROOT,
            "--merge-install",
            "--cmake-args",
            "-DCMAKE_C_FLAGS=-O0",
            "-DCMAKE_CXX_FLAGS=-O0",
        ],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    (folder / "venv").symlink_to(sys.prefix)
    return folder


def sourced(workspace: Path, command: str) -> str:
    """Run a shell command after sourcing the workspace; return what it prints."""
    result = subprocess.run(
        ["sh", "-c", f". install/local_setup.sh && {command}"],
        cwd=workspace,
        env=os.environ
        | {
            "PATH": f"{sys.prefix}/bin:{os.environ['PATH']}",
            # colcon's script does not quote its Python, and the checkout's path may hold a space.
            "COLCON_PYTHON_EXECUTABLE": f"{workspace}/venv/bin/python",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


@pytest.mark.parametrize("package", ["flexsim_msgs.msg", "flexsim_node", "thermal_node"])
def test_packages_import_from_the_install_space(workspace: Path, package: str) -> None:
    where = sourced(workspace, f"python -c 'import {package} as p; print(p.__file__)'")
    assert Path(where).is_relative_to(workspace / "install")


def test_messages_are_sent_with_the_install_spaces_own_libraries(workspace: Path) -> None:
    program = (
        "from rclpy.serialization import serialize_message as s; "
        "from flexsim_msgs.msg import ElasticState as E; s(E()); "
        'print(*[line.split()[-1] for line in open("/proc/self/maps") if "flexsim_msgs" in line])'
    )
    libraries = sourced(workspace, f"python -c '{program}'").split()
    assert libraries
    assert all(Path(library).is_relative_to(workspace / "install") for library in libraries)


@pytest.mark.parametrize("node", ["flexsim_node", "thermal_node"])
def test_ros2_run_finds_the_node_and_its_scenes(workspace: Path, node: str) -> None:
    assert os.access(workspace / "install" / "lib" / node / node, os.X_OK)
    assert (workspace / "install" / "share" / node / "config").is_dir()
