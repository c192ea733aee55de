"""Solving with the factors of co_moving_factorization.py: loads go to the base, answers come back."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import COUNT, FIRST, FIXED, KEPT_MOMENT, KEPT_TURN, KIND, MOTOR, PARENT, PRISMATIC, Q
from ..co_moving.space import turned, turned_back
from .co_moving_factorization import joint_column
from .joint_elimination import free


@kernel
def turn_vector(r, g, dofs):
    """Turn a load or an acceleration g forward by the rotation r, in place."""
    if len(dofs) == 3:
        g[0], g[1] = r[0] * g[0] - r[3] * g[1], r[3] * g[0] + r[0] * g[1]
        return
    g[0], g[1], g[2] = turned(r, g[0], g[1], g[2])
    g[3], g[4], g[5] = turned(r, g[3], g[4], g[5])


@kernel
def turn_vector_back(r, g, dofs):
    """The same by the transposed rotation."""
    if len(dofs) == 3:
        g[0], g[1] = r[0] * g[0] + r[3] * g[1], r[0] * g[1] - r[3] * g[0]
        return
    g[0], g[1], g[2] = turned_back(r, g[0], g[1], g[2])
    g[3], g[4], g[5] = turned_back(r, g[3], g[4], g[5])


@kernel
def shift_load(kept, g, dofs):
    """Move a load's point back by the kept reach: its force gets a moment."""
    x, y, u = kept[9], kept[10], kept[11]
    if len(dofs) == 3:
        g[2] += x * g[1] - y * g[0]
        return
    g[3] += y * g[2] - u * g[1]
    g[4] += u * g[0] - x * g[2]
    g[5] += x * g[1] - y * g[0]


@kernel
def shift_answer(kept, g, dofs):
    """Move an acceleration's point on by the kept reach."""
    x, y, u = kept[9], kept[10], kept[11]
    if len(dofs) == 3:
        g[0] -= g[2] * y
        g[1] += g[2] * x
        return
    g[0] += g[4] * u - g[5] * y
    g[1] += g[5] * x - g[3] * u
    g[2] += g[3] * y - g[4] * x


@kernel
def solve(chain, work, rhs, out):
    """Solve for out (n,) with the factors at hand; rhs (n,) is kept.  Held joints get zero."""
    link, index = chain.link, chain.unknown
    b = len(chain.dofs)
    dofs = chain.dofs
    load, answer, f, column = work.section_load, work.section_answer, work.row[1], work.row[3]
    load[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        first, parent = link[n, FIRST], link[n, PARENT]
        for i in range(first + link[n, COUNT], first, -1):
            g, kept = load[i], work.kept_moving[i]
            s, p = kept[KEPT_TURN : KEPT_TURN + 15], kept[KEPT_MOMENT : KEPT_MOMENT + 9]
            shift_load(kept, g, dofs)
            if len(dofs) == 3:
                f[0], f[1], f[2] = g[0], g[2], p[0] * g[1] + g[2]
            else:
                f[0] = g[0]
                for k in range(5):
                    f[1 + k] = s[3 * k] * g[3] + s[3 * k + 1] * g[4] + s[3 * k + 2] * g[5]
                for k in range(3):
                    f[3 + k] += p[3 * k + 1] * g[1] + p[3 * k + 2] * g[2]
            for k in range(b):
                f[b + k] = g[k]
            for k in range(b):
                if index[i, k] < 0:
                    continue
                row = work.pivot[i * b + k]
                y = (f[k] + rhs[index[i, k]]) * row[2 * b]
                out[index[i, k]] = y
                for j in range(k + 1, 2 * b):
                    f[j] -= row[j] * y
            turn_vector(kept, f[b : 2 * b], dofs)
            for k in range(b):
                load[i - 1, k] += f[b + k]
        g, kept = load[first], work.kept_moving[first]
        if free(link, work.held, n):
            row = work.joint_pivot[n, 1]
            joint_column(chain, n, dofs, column)
            y = rhs[link[n, Q]]
            motor = link[n, MOTOR]
            if motor >= 0:
                y += work.spring[n, 0] * work.spring[n, 1] * rhs[motor]
            for k in range(b):
                y += column[k] * g[k]
            y *= row[b]
            out[link[n, Q]] = y
            for k in range(b):
                g[k] -= row[k] * y
        if parent >= 0:
            turn_vector(kept, g, dofs)
            if link[n, KIND] == PRISMATIC:
                shift_load(kept, g, dofs)
            before = load[link[parent, FIRST] + link[parent, COUNT]]
            for k in range(b):
                before[k] += g[k]
    for n in range(link.shape[0]):
        first, parent = link[n, FIRST], link[n, PARENT]
        z, kept = answer[first], work.kept_moving[first]
        for k in range(b):
            z[k] = 0.0
        if parent >= 0:
            before = answer[link[parent, FIRST] + link[parent, COUNT]]
            for k in range(b):
                z[k] = before[k]
            if link[n, KIND] == PRISMATIC:
                shift_answer(kept, z, dofs)
            turn_vector_back(kept, z, dofs)
        if link[n, KIND] != FIXED:
            if not free(link, work.held, n):
                out[link[n, Q]] = 0.0
            else:
                row = work.joint_pivot[n, 1]
                joint_column(chain, n, dofs, column)
                y = out[link[n, Q]]
                for k in range(b):
                    y -= row[b] * row[k] * z[k]
                out[link[n, Q]] = y
                for k in range(b):
                    z[k] += column[k] * y
                motor = link[n, MOTOR]
                if motor >= 0:
                    out[motor] = work.spring[n, 1] * (rhs[motor] + work.spring[n, 0] * y)
        for i in range(first + 1, first + link[n, COUNT] + 1):
            z, kept = answer[i], work.kept_moving[i]
            for k in range(b):
                z[k] = answer[i - 1, k]
            turn_vector_back(kept, z, dofs)
            for k in range(b):
                f[b + k] = z[k]
            for k in range(b - 1, -1, -1):
                f[k] = 0.0
                if index[i, k] < 0:
                    continue
                row = work.pivot[i * b + k]
                total = 0.0
                for j in range(k + 1, 2 * b):
                    total += row[j] * f[j]
                f[k] = out[index[i, k]] - row[2 * b] * total
                out[index[i, k]] = f[k]
            s, p = kept[KEPT_TURN : KEPT_TURN + 15], kept[KEPT_MOMENT : KEPT_MOMENT + 9]
            if len(dofs) == 3:
                z[0] += f[0]
                z[1] += p[0] * f[2]
                z[2] += f[1] + f[2]
            else:
                z[0] += f[0]
                for k in range(1, 3):
                    z[k] += p[k] * f[3] + p[3 + k] * f[4] + p[6 + k] * f[5]
                for k in range(3):
                    for j in range(5):
                        z[3 + k] += s[3 * j + k] * f[1 + j]
            shift_answer(kept, z, dofs)
