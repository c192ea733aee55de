"""Coulomb friction of the joints: one force a joint, solved with the motion and not after it.

The friction f of a joint with limit F and rate w is Coulomb's law itself, with values in a set at rest,

    f = F sign(w)  where w is not 0,    |f| <= F  where w = 0,

or, where a scene gives `coulomb_speed` s, the smooth f = F tanh(w / s).  Both rise with w.

An implicit method's step solves S da = r - J^T f with rates w = w0 + c J da, where J picks the joints' rates
out of the unknowns' and S is positive definite.  With Y = S^-1 J^T and W = J Y the forces obey

    w = w0 - c W (f - f0),    f of w by the law,

a strictly monotone system with one solution, whatever step, inertia and friction are.  It is solved exactly
here, so that a joint that can be held has a rate of zero, and the matrix of the motion never holds friction.
It is Moreau's time stepping in its implicit form: Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235.

Nothing is kept from step to step: the forces follow from the rates at a stage's start.
"""

from __future__ import annotations

from math import tanh

from ...compiled.kernel import kernel
from ...model.chain import COORDINATES, COULOMB, COULOMB_SPEED, MOTOR, PHI, Q
from ..solve.substitution import solve
from .closure import CLOSING_STEPS, close, project

# columns of Workspace.rubbing, a row for each joint with Coulomb friction: Y (n), W (k), a matrix (k), and
# then the friction, the joint's rate, whether it was at rest (the acceleration decides then), its share in
# the motion, a right side, a force to try, the rate that `rub_by_rate` saw
FORCE, SPEED, STUCK, SHARE, RIGHT, TRIAL, BEGUN = range(7)
COLUMNS = 7
ROUNDS = 200
STANDING = 1e-12  # rad/s and m/s: as slow as this is rounding of a rate of zero
STABLE = 2.5  # of explicit methods, step times slope of the friction over inertia
SATURATED = 20.0  # of w / s, beyond which tanh is 1 to rounding
RESTING = 1e-13  # m, rad and their rates: off by this much a held joint is where it was
IMMOBILE = 1e-10  # share of a joint's own mobility that loops leave it, below which it can't move


@kernel
def joint_rate(link, n, v):
    """Rate at which a joint rubs: of its motor where a spring follows, else of the joint as a whole."""
    if link[n, MOTOR] >= 0:
        return v[link[n, MOTOR]]
    return v[link[n, Q]] + (v[link[n, PHI]] if link[n, PHI] >= 0 else 0.0)


@kernel
def at_rate(limit, speed, w):
    """Friction at the rate w; none at rest."""
    if speed > 0.0:
        return limit * tanh(w / speed)
    return limit if w > 0.0 else (-limit if w < 0.0 else 0.0)


@kernel
def rub_by_rate(chain, work, v):
    """Set the friction of every joint from the rates v (n,); joints at rest are left to the acceleration."""
    if chain.rubbing.size == 0:
        return
    joint, rubs = chain.joint, chain.rubbing
    tail = work.rubbing.shape[1] - COLUMNS
    for p in range(rubs.size):
        n, row = rubs[p], work.rubbing[p]
        w = joint_rate(chain.link, n, v)
        row[tail + FORCE] = at_rate(joint[n, COULOMB], joint[n, COULOMB_SPEED], w)
        row[tail + BEGUN] = w
        row[tail + STUCK] = 1.0 if w == 0.0 and joint[n, COULOMB_SPEED] == 0.0 else 0.0


@kernel
def rub_smoothly(chain, work, v):
    """Set the friction that is a function of the rate v (n,); that of Coulomb's law itself stays."""
    if chain.rubbing.size == 0:
        return
    joint, rubs = chain.joint, chain.rubbing
    tail = work.rubbing.shape[1] - COLUMNS
    for p in range(rubs.size):
        n = rubs[p]
        if joint[n, COULOMB_SPEED] > 0.0:
            w = joint_rate(chain.link, n, v)
            work.rubbing[p, tail + FORCE] = at_rate(joint[n, COULOMB], joint[n, COULOMB_SPEED], w)


@kernel
def columns(chain, work, damped):
    """Write Y and W with the factors at hand; joints that are held, or that loops hold, have no share.

    `damped` scales the elastic part, as in the integrators.
    """
    link, rubs, table = chain.link, chain.rubbing, work.rubbing
    n, k, unit = work.memory.size, chain.rubbing.size, work.vector[8]
    tail = table.shape[1] - COLUMNS
    for p in range(k):
        at, y = rubs[p], table[p, 0:n]
        motor, phi = link[at, MOTOR], link[at, PHI]
        unit[:] = 0.0
        unit[motor if motor >= 0 else link[at, Q]] = 1.0
        if motor < 0 and phi >= 0:
            unit[phi] = 1.0
        solve(chain, work, unit, y)
        for i in range(int(chain.setting[COORDINATES]), n):
            y[i] *= damped
        alone = joint_rate(link, at, y)
        project(chain.loops, chain, work, y)
        own = joint_rate(link, at, y)
        moves = not work.held[at] and own > IMMOBILE * alone
        table[p, tail + SHARE] = 1.0 if moves else 0.0
    for p in range(k):
        for q in range(k):
            table[p, n + q] = joint_rate(link, rubs[p], table[q, 0:n])


@kernel
def obeyed(limit, speed, u, g):
    """Friction of one joint alone: f in the law of w = u - g f, g > 0."""
    if speed == 0.0:
        return max(-limit, min(limit, u / g))
    # t + kappa tanh(t) = tau for t = w / s: concave where t > 0, so that Newton's method climbs to the root
    kappa, tau = g * limit / speed, abs(u) / speed
    t = tau / (1.0 + kappa)
    for _ in range(50):
        th = tanh(t)
        step = (tau - t - kappa * th) / (1.0 + kappa * (1.0 - th * th))
        t += step
        if not step > 1e-15 * t:
            break
    f = limit * tanh(t)
    return f if u > 0.0 else -f


@kernel
def unrest(chain, work, c, at):
    """How far the forces in column `at`, with their rates, are from the law, as a share of the limits."""
    rubs, table, n = chain.rubbing, work.rubbing, work.memory.size
    tail = table.shape[1] - COLUMNS
    largest = 0.0
    for p in range(rubs.size):
        if table[p, tail + SHARE] == 0.0:
            continue
        limit, g = chain.joint[rubs[p], COULOMB], c * table[p, n + p]
        w = speed_with(chain, work, c, at, p)
        f = table[p, tail + at]
        change = abs(obeyed(limit, chain.joint[rubs[p], COULOMB_SPEED], w + g * f, g) - f)
        # what rounding of the rates leaves of the force
        largest = max(largest, (change - 4e-16 * (abs(w) + abs(table[p, tail + SPEED])) / g) / limit)
    return largest


@kernel
def speed_with(chain, work, c, at, p):
    """Rate of joint p with the forces in column `at`; SPEED is that with the forces FORCE."""
    table, n = work.rubbing, work.memory.size
    tail = table.shape[1] - COLUMNS
    w = table[p, tail + SPEED]
    for q in range(chain.rubbing.size):
        w -= c * table[p, n + q] * (table[q, tail + at] - table[q, tail + FORCE])
    return w


@kernel
def sweep(chain, work, c):
    """Let each joint's trial force obey the law, the others as they are: Gauss and Seidel's way."""
    rubs, table, n = chain.rubbing, work.rubbing, work.memory.size
    tail = table.shape[1] - COLUMNS
    for p in range(rubs.size):
        if table[p, tail + SHARE] == 0.0:
            continue
        g, f = c * table[p, n + p], table[p, tail + TRIAL]
        u = speed_with(chain, work, c, TRIAL, p) + g * f
        table[p, tail + TRIAL] = obeyed(
            chain.joint[rubs[p], COULOMB], chain.joint[rubs[p], COULOMB_SPEED], u, g
        )


@kernel
def newton(chain, work, c):
    """One step of Newton's method on all joints together, from the trial forces into RIGHT."""
    joint, rubs, table = chain.joint, chain.rubbing, work.rubbing
    n, k = work.memory.size, chain.rubbing.size
    tail, matrix = table.shape[1] - COLUMNS, n + k
    for p in range(k):
        row, limit, speed = table[p], joint[rubs[p], COULOMB], joint[rubs[p], COULOMB_SPEED]
        for q in range(k):
            row[matrix + q] = 0.0
        row[matrix + p] = 1.0
        row[tail + RIGHT] = 0.0
        if row[tail + SHARE] == 0.0:
            continue
        f, w = row[tail + TRIAL], speed_with(chain, work, c, TRIAL, p)
        if speed > 0.0:
            th = tanh(w / speed)
            slope = limit / speed * (1.0 - th * th)
            for q in range(k):
                row[matrix + q] += slope * c * row[n + q] * table[q, tail + SHARE]
            row[tail + RIGHT] = limit * th - f
        elif abs(f) < limit:
            for q in range(k):
                row[matrix + q] = c * row[n + q] * table[q, tail + SHARE]
            row[tail + RIGHT] = w
    sound = eliminate(table, matrix, tail + RIGHT, k)
    for p in range(k):
        limit, f = joint[rubs[p], COULOMB], table[p, tail + TRIAL] + table[p, tail + RIGHT]
        table[p, tail + RIGHT] = max(-limit, min(limit, f))
    return sound


@kernel
def eliminate(table, matrix, right, k):
    """Solve the k equations in columns `matrix` on of the table, answer in `right`; tells whether they could.

    An equation that follows from the others gets no answer of its own.
    """
    sound = True
    for i in range(k):
        best = i
        for p in range(i + 1, k):
            if abs(table[p, matrix + i]) > abs(table[best, matrix + i]):
                best = p
        if best != i:
            for q in range(i, k):
                table[i, matrix + q], table[best, matrix + q] = table[best, matrix + q], table[i, matrix + q]
            table[i, right], table[best, right] = table[best, right], table[i, right]
        size = 0.0
        for q in range(i, k):
            size = max(size, abs(table[i, matrix + q]))
        if not abs(table[i, matrix + i]) > 1e-13 * size:
            sound = False
            for q in range(i, k):
                table[i, matrix + q] = 0.0
            table[i, matrix + i], table[i, right] = 1.0, 0.0
        for p in range(i + 1, k):
            factor = table[p, matrix + i] / table[i, matrix + i]
            for q in range(i, k):
                table[p, matrix + q] -= factor * table[i, matrix + q]
            table[p, right] -= factor * table[i, right]
    for i in range(k - 1, -1, -1):
        for q in range(i + 1, k):
            table[i, right] -= table[i, matrix + q] * table[q, right]
        table[i, right] /= table[i, matrix + i]
    return sound


@kernel
def settle(chain, work, c):
    """Find the forces TRIAL of the law, from FORCE and the rates SPEED that belong to these.

    Sweeps converge from anywhere, Newton's steps fast where they lead nearer.  Tells whether it got there.
    """
    table, k = work.rubbing, chain.rubbing.size
    tail = table.shape[1] - COLUMNS
    for p in range(k):
        table[p, tail + TRIAL] = table[p, tail + FORCE]
    left = 0.0
    for _ in range(ROUNDS):
        sweep(chain, work, c)
        left = unrest(chain, work, c, TRIAL)
        if left <= 1e-13:
            return True
        if newton(chain, work, c) and unrest(chain, work, c, RIGHT) < left:
            for p in range(k):
                table[p, tail + TRIAL] = table[p, tail + RIGHT]
    return left <= 1e-9


@kernel
def saturated(chain, work):
    """Whether the friction of every joint is its limit, against its rate SPEED, or it is held."""
    rubs, table = chain.rubbing, work.rubbing
    tail = table.shape[1] - COLUMNS
    for p in range(rubs.size):
        n, f, w = rubs[p], table[p, tail + FORCE], table[p, tail + SPEED]
        limit = chain.joint[n, COULOMB]
        beyond = SATURATED * chain.joint[n, COULOMB_SPEED]
        if not (work.held[n] or (f == limit and w > beyond) or (f == -limit and w < -beyond)):
            return False
    return True


@kernel
def change(chain, work, damped, da):
    """Take the trial forces, and what they change of the answer da (n,)."""
    table, n, m = work.rubbing, work.memory.size, int(chain.setting[COORDINATES])
    tail = table.shape[1] - COLUMNS
    for p in range(chain.rubbing.size):
        more = table[p, tail + TRIAL] - table[p, tail + FORCE]
        table[p, tail + FORCE] = table[p, tail + TRIAL]
        if more == 0.0:
            continue
        for i in range(n):
            da[i] -= more * table[p, i] if i < m else more * table[p, i] / damped


@kernel
def rub(chain, work, v, da, c, damped, before, lag):
    """Correct the answer da of a solve, with the forces at hand, so that at rates v + c da the law holds.

    Coulomb's law itself is held at rates less by lag times the rates `before`.  `damped` scales the elastic
    part, as in the integrators.  Tells whether forces were found.
    """
    if chain.rubbing.size == 0:
        return True
    rubs, table, y = chain.rubbing, work.rubbing, work.vector[8]
    tail, m = table.shape[1] - COLUMNS, int(chain.setting[COORDINATES])
    for i in range(da.size):
        y[i] = v[i] + c * (da[i] if i < m else damped * da[i])
    # rates that the loops allow: joints of one mechanism can come to rest together only at those
    project(chain.loops, chain, work, y)
    for p in range(rubs.size):
        table[p, tail + SPEED] = joint_rate(chain.link, rubs[p], y)
    if lag > 0.0:
        for i in range(da.size):
            y[i] = before[i]
        project(chain.loops, chain, work, y)
        for p in range(rubs.size):
            if chain.joint[rubs[p], COULOMB_SPEED] == 0.0:
                table[p, tail + SPEED] -= lag * joint_rate(chain.link, rubs[p], y)
    if saturated(chain, work):
        return True
    columns(chain, work, damped)
    found = settle(chain, work, c)
    change(chain, work, damped, da)
    return found


@kernel
def stick(chain, work, da):
    """Correct accelerations da (n,) so that joints at rest stay there where their friction can hold them."""
    if chain.rubbing.size == 0:
        return True
    rubs, table = chain.rubbing, work.rubbing
    tail = table.shape[1] - COLUMNS
    resting = False
    for p in range(rubs.size):
        stuck = table[p, tail + STUCK] > 0.0 and not work.held[rubs[p]]
        resting = resting or stuck
    if not resting:
        return True
    columns(chain, work, 1.0)
    for p in range(rubs.size):
        if table[p, tail + STUCK] == 0.0:
            table[p, tail + SHARE] = 0.0
        table[p, tail + SPEED] = joint_rate(chain.link, rubs[p], da)
    found = settle(chain, work, 1.0)
    change(chain, work, 1.0, da)
    return found


@kernel
def stop(chain, work, x, v, h):
    """End an explicit step h during which joints rubbed as at its start: those that turned round stop.

    What changes of their friction counts as a constant force over the step.  Returns whether forces were
    found, and whether smooth friction changes slowly enough for the step.
    """
    if chain.rubbing.size == 0:
        return True, True
    joint, rubs, table, n = chain.joint, chain.rubbing, work.rubbing, work.memory.size
    tail = table.shape[1] - COLUMNS
    broken = near = False
    for p in range(rubs.size):
        row, limit, speed = table[p], joint[rubs[p], COULOMB], joint[rubs[p], COULOMB_SPEED]
        w = row[tail + SPEED] = joint_rate(chain.link, rubs[p], v)
        f = row[tail + FORCE]
        if work.held[rubs[p]]:
            continue
        if speed == 0.0:
            broken = broken or (w > STANDING and f < limit) or (w < -STANDING and f > -limit)
        else:
            near = near or abs(w) < SATURATED * speed or w * row[tail + BEGUN] < 0.0
    if broken or near:
        columns(chain, work, 1.0)
        for p in range(rubs.size):
            row, limit, speed = table[p], joint[rubs[p], COULOMB], joint[rubs[p], COULOMB_SPEED]
            if speed > 0.0:
                w = row[tail + SPEED]
                passed = abs(w) < SATURATED * speed or w * row[tail + BEGUN] < 0.0
                if passed and row[tail + SHARE] > 0.0 and h * row[n + p] * limit > STABLE * speed:
                    return True, False
                row[tail + SHARE] = 0.0
    if broken:
        if not settle(chain, work, h):
            return False, True
        for p in range(rubs.size):
            more = table[p, tail + TRIAL] - table[p, tail + FORCE]
            table[p, tail + FORCE] = table[p, tail + TRIAL]
            for i in range(n):
                v[i] -= h * more * table[p, i]
                x[i] -= 0.5 * h * h * more * table[p, i]
    stand_still(chain, work, v)
    return True, True


@kernel
def is_held(chain, work, p):
    """Whether friction holds a joint: by Coulomb's law itself, below its limit."""
    n, row = chain.rubbing[p], work.rubbing[p]
    tail = work.rubbing.shape[1] - COLUMNS
    below = abs(row[tail + FORCE]) < chain.joint[n, COULOMB]
    return chain.joint[n, COULOMB_SPEED] == 0.0 and below and not work.held[n]


@kernel
def is_put_back(chain, work, p, rested):
    """Whether `put_back` moves a joint: friction holds it, it can move, and it was at rest if it has to."""
    row = work.rubbing[p]
    tail = work.rubbing.shape[1] - COLUMNS
    before = row[tail + STUCK] > 0.0 or not rested
    return is_held(chain, work, p) and row[tail + SHARE] > 0.0 and before


@kernel
def stand_still(chain, work, v):
    """Clear what rounding leaves of the rates v of joints that friction holds."""
    if chain.rubbing.size == 0:
        return
    link = chain.link
    for p in range(chain.rubbing.size):
        n = chain.rubbing[p]
        if is_held(chain, work, p):
            if link[n, MOTOR] >= 0:
                v[link[n, MOTOR]] = 0.0
            elif link[n, PHI] >= 0:
                v[link[n, PHI]] = -v[link[n, Q]]
            else:
                v[link[n, Q]] = 0.0


@kernel
def stay(chain, work, x, v, end):
    """Take from positions `end` (n,) what a step from x, v has moved joints that were and are held."""
    if chain.rubbing.size == 0:
        return
    rubs, table = chain.rubbing, work.rubbing
    tail = table.shape[1] - COLUMNS
    held = False
    for p in range(rubs.size):
        table[p, tail + SPEED] = joint_rate(chain.link, rubs[p], x)
        rested = joint_rate(chain.link, rubs[p], v) == 0.0
        table[p, tail + STUCK] = 1.0 if rested else 0.0
        held = held or (rested and is_held(chain, work, p))
    if held:
        put_back(chain, work, end, True, True)


@kernel
def close_resting(loops, chain, work, x, v, still):
    """`close`, with joints that friction holds where they are; False where the loops stay open."""
    if len(loops) == 0 or chain.rubbing.size == 0:
        return close(loops, chain, work, x, v, still)
    rubs, table = chain.rubbing, work.rubbing
    tail = table.shape[1] - COLUMNS
    held = False
    for p in range(rubs.size):
        held = held or is_held(chain, work, p)
        table[p, tail + SPEED] = joint_rate(chain.link, rubs[p], x)
    for _ in range(CLOSING_STEPS):
        if not close(loops, chain, work, x, v, still):
            return False
        if not held:
            return True
        away = put_back(chain, work, x, True, False)
        away = max(away, put_back(chain, work, v, False, False))
        if not away > RESTING:
            break
    return True


@kernel
def put_back(chain, work, y, position, rested):
    """Bring held joints back to positions SPEED, or to a rate of zero; returns how far off they were.

    `rested`: only those that were at rest before, too.
    """
    rubs, table, n, k = chain.rubbing, work.rubbing, work.memory.size, chain.rubbing.size
    tail, matrix = table.shape[1] - COLUMNS, work.memory.size + chain.rubbing.size
    largest = 0.0
    for p in range(k):
        row, holds = table[p], is_put_back(chain, work, p, rested)
        for q in range(k):
            row[matrix + q] = row[n + q] if holds and is_put_back(chain, work, q, rested) else 0.0
        row[tail + RIGHT] = 0.0
        if holds:
            row[tail + RIGHT] = joint_rate(chain.link, rubs[p], y) - (row[tail + SPEED] if position else 0.0)
            largest = max(largest, abs(row[tail + RIGHT]))
        else:
            row[matrix + p] = 1.0
    eliminate(table, matrix, tail + RIGHT, k)
    for p in range(k):
        for i in range(n):
            y[i] -= table[p, tail + RIGHT] * table[p, i]
    return largest
