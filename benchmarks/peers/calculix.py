"""The same door in CalculiX: DC3D8 bricks, implicit Euler (*HEAT TRANSFER), nodal temperatures.

CalculiX is a program of its own: `apt-get install calculix-ccx`. What it is given is the mesh, the
materials' tables and the surfaces of one of our models, so that both solve one problem.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from thermal_node.heat.conduction import ABSOLUTE_ZERO, STEFAN_BOLTZMANN
from thermal_node.model.door_model import DoorModel

CCX = "ccx"


@dataclass(frozen=True)
class CalculixRun:
    """time (K,), s; temperature (K, N), °C, in our order of nodes; cpu : s of processor time."""

    time: np.ndarray
    temperature: np.ndarray
    cpu: float


def available() -> bool:
    """Whether CalculiX is installed."""
    return shutil.which(CCX) is not None


def burn(
    model: DoorModel,
    step: float,
    duration: float = 3600.0,
    every: float = 60.0,
    specific_heat_knots: dict[str, np.ndarray] | None = None,
) -> CalculixRun:
    """March a model of ours with CalculiX, `step` s each, keeping a field each `every` s.

    specific_heat_knots : the temperatures, °C, of a material's table; our own knots if not given
    """
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "door.inp"
        with deck.open("w") as file:
            _write(file, model, step, duration, every, specific_heat_knots or {})
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        outcome = subprocess.run(
            [CCX, "door"], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if "Job finished" not in outcome.stdout:
            raise RuntimeError(f"CalculiX stopped: {outcome.stdout[-500:]}{outcome.stderr[-500:]}")
        time, temperature = _read(Path(folder) / "door.dat", len(model.nodes))
    order = np.argsort(time)
    return CalculixRun(time[order], temperature[order], cpu)


def _write(file, model, step, duration, every, knots) -> None:
    mesh = model.mesh
    nz, ny, nx = mesh.shape
    if min(nz, ny, nx) < 2:
        raise ValueError("CalculiX gets a mesh of bricks: resolve all three directions")
    file.write("*NODE, NSET=ALL\n")
    for i, (x, y, z) in enumerate(mesh.nodes, start=1):
        file.write(f"{i}, {x:.9g}, {y:.9g}, {z:.9g}\n")
    k, j, i = np.meshgrid(np.arange(nz - 1), np.arange(ny - 1), np.arange(nx - 1), indexing="ij")
    base = ((k * ny + j) * nx + i).ravel() + 1
    plane = nx * ny
    corners = base[:, None] + np.array([0, 1, nx + 1, nx, plane, plane + 1, plane + nx + 1, plane + nx])
    material = mesh.brick_material.ravel()
    for m, name in enumerate(mesh.material_names):
        file.write(f"*ELEMENT, TYPE=DC3D8, ELSET=E_{name}\n")
        for e in np.flatnonzero(material == m):
            file.write(f"{e + 1}, " + ", ".join(map(str, corners[e])) + "\n")
    bricks = (nx - 1) * (ny - 1)
    file.write(f"*ELSET, ELSET=HOT, GENERATE\n1, {bricks}, 1\n")
    file.write(f"*ELSET, ELSET=COLD, GENERATE\n{len(base) - bricks + 1}, {len(base)}, 1\n")
    for m, name in enumerate(mesh.material_names):
        known = model.materials[m]
        file.write(f"*MATERIAL, NAME={name}\n*DENSITY\n{known.density:.9g}\n*CONDUCTIVITY\n")
        t = known.conductivity.knots
        for at, value in zip(t, known.conductivity(t), strict=True):
            file.write(f"{value:.9g}, {at:.9g}\n")
        t = knots.get(name, known.specific_heat.knots)
        file.write("*SPECIFIC HEAT\n")
        for at, value in zip(t, known.specific_heat(t), strict=True):
            file.write(f"{value:.9g}, {at:.9g}\n")
        file.write(f"*SOLID SECTION, ELSET=E_{name}, MATERIAL={name}\n")
    file.write(f"*PHYSICAL CONSTANTS, ABSOLUTE ZERO={ABSOLUTE_ZERO}, STEFAN BOLTZMANN={STEFAN_BOLTZMANN}\n")
    file.write(f"*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, {model.initial:.9g}\n")
    file.write("*AMPLITUDE, NAME=FURNACE\n")
    times = np.arange(0.0, duration + 0.5 * step, step)
    for t in times:
        file.write(f"{t:.9g}, {float(model.furnace(t)):.12g}\n")
    file.write(f"*AMPLITUDE, NAME=ROOM\n0., {model.ambient:.9g}\n{duration:.9g}, {model.ambient:.9g}\n")
    file.write(f"*STEP, INC={10 * len(times)}\n*HEAT TRANSFER, DIRECT\n{step:.9g}, {duration:.9g}\n")
    film, emissivity = model.surface.film, model.surface.emissivity
    for s, (name, face, amplitude) in enumerate((("HOT", 1, "FURNACE"), ("COLD", 2, "ROOM"))):
        if film[s]:
            file.write(f"*FILM, AMPLITUDE={amplitude}\n{name}, F{face}, 1., {film[s]:.9g}\n")
        if emissivity[s]:
            file.write(f"*RADIATE, AMPLITUDE={amplitude}\n{name}, R{face}, 1., {emissivity[s]:.9g}\n")
    file.write(f"*NODE PRINT, NSET=ALL, FREQUENCY={round(every / step)}\nNT\n*END STEP\n")


def _read(path: Path, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    times, fields, field = [], [], np.zeros(nodes)
    with path.open() as file:
        for line in file:
            words = line.split()
            if line.startswith(" temperatures"):
                times.append(float(words[-1]))
                field = np.full(nodes, np.nan)
                fields.append(field)
            elif len(words) == 2:
                field[int(words[0]) - 1] = float(words[1])
    return np.array(times), np.array(fields)
