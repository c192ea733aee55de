"""The robots in MuJoCo (PyPI: mujoco): each link a chain of rigid pieces with springs between them.

Each of a link's n springs bends as an nth of the link bends, with a rectangle's two bending stiffnesses.
"middles" puts them where n equal beams have their middles (second order in 1/n, but the pieces at the ends
are half as long and light, which asks for small steps); "equal" cuts n + 1 equal pieces, as MuJoCo's own
cable does (first order, larger steps).
"""

from __future__ import annotations

import time

import numpy as np

from .exudyn_robot import Attempt
from .problem import YOUNG, Problem


def chain(problem: Problem, cut: str, springs: int, step: float, integrator: str, planar: bool) -> str:
    """The model's XML."""
    shear_modulus = YOUNG / (2.0 * (1.0 + problem.poisson))
    e_z = np.array(problem.axes[-1], dtype=float)
    lines, depth, offset = [], 0, np.zeros(3)
    for number, link in enumerate(problem.links):
        e_x = np.array(link.direction, dtype=float)
        e_y = np.cross(e_z, e_x)
        torsion, second_y, second_z = link.bending
        part = link.length / springs
        pieces = [0.5 * part, *[part] * (springs - 1), 0.5 * part]
        if cut == "equal":
            pieces = [link.length / (springs + 1)] * (springs + 1)
        rotation = np.column_stack([e_x, e_y, e_z])
        for k, length in enumerate(pieces):
            mass = problem.density * link.area * length
            sides = (link.side_y**2, link.side_z**2) if problem.section_inertia else (0.0, 0.0)
            tiny = 1e-9 * mass
            inertia = (
                mass / 12.0 * np.array([sides[0] + sides[1], length**2 + sides[1], length**2 + sides[0]])
            )
            inertia = rotation @ np.diag(np.maximum(inertia, tiny)) @ rotation.T
            lines.append(f'<body pos="{_said(offset)}">')
            if k == 0:
                lines.append(f'<joint name="q{number}" type="hinge" axis="{_said(problem.axes[number])}"/>')
            else:
                hinges = [(e_z, YOUNG * second_z)]
                if not planar:
                    hinges += [(e_y, YOUNG * second_y), (e_x, shear_modulus * torsion)]
                for axis, stiffness in hinges:
                    lines.append(
                        f'<joint type="hinge" axis="{_said(axis)}" stiffness="{stiffness / part:.12g}"/>'
                    )
            full = _said([*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]])
            lines.append(
                f'<inertial pos="{_said(0.5 * length * e_x)}" mass="{mass:.12g}" fullinertia="{full}"/>'
            )
            depth += 1
            offset = length * e_x
    lines.append(f'<site name="tip" pos="{_said(offset)}"/>')
    motor = '<actuator><motor joint="q0"/></actuator>' if problem.torque else ""
    return (
        f'<mujoco><compiler balanceinertia="true"/><option timestep="{step:.12g}" integrator="{integrator}"'
        f' gravity="{_said(problem.gravity)}"><flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{''.join(lines)}{'</body>' * depth}</worldbody>{motor}</mujoco>"
    )


def attempt(
    problem: Problem, cut: str, springs: int, step: float, integrator: str, planar: bool, repeats: int
) -> Attempt:
    """Run it, a sample's steps in one call of MuJoCo's own loop (`rollout`, without Python between steps).

    The torque is that at each step's beginning, for RK4 held over the step's middle.
    """
    import mujoco
    from mujoco.rollout import rollout

    model = mujoco.MjModel.from_xml_string(chain(problem, cut, springs, step, integrator, planar))
    every = round(problem.period / step)
    count = len(problem.reference)
    tip = np.full((count, 3), np.nan)
    seconds = []
    shift = 0.5 * step if integrator == "RK4" else 0.0
    torque = problem.torque * np.sin(2.0 * np.pi * (np.arange((count - 1) * every) * step + shift))
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    for _ in range(repeats):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        tip[0] = data.site("tip").xpos
        took = 0.0
        for k in range(1, count):
            if problem.torque:
                begun = time.process_time()
                start = np.zeros((1, mujoco.mj_stateSize(model, full)))
                mujoco.mj_getState(model, data, start[0], full)
                held = torque[(k - 1) * every : k * every].reshape(1, every, 1)
                rollout(model, data, start, held)
                took += time.process_time() - begun
            else:
                begun = time.process_time()
                mujoco.mj_step(model, data, every)
                took += time.process_time() - begun
            mujoco.mj_kinematics(model, data)
            tip[k] = data.site("tip").xpos
            if not np.linalg.norm(tip[k] - tip[0]) < 10.0:
                break  # it has come apart
        seconds.append(took / problem.duration)
    return Attempt(seconds, tip)


def _said(vector) -> str:
    return " ".join(f"{float(x):.12g}" for x in vector)
