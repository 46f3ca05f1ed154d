"""The largest dip of eq. (24) by simulation and local search: an oracle for tests, which proves nothing.

Both UAVs are simulated with explicit formulas for piecewise constant inputs, and every constraint of a reading is
checked on the trajectories themselves. What `best_dip` returns is the dip of a feasible pair, hence a lower bound of
the true one (up to 1e-9). The arrays have the axes pair, UAV (2), coordinate (3) and, for inputs, piece.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Array = NDArray[np.float64]
Vector3 = tuple[float, float, float]

READINGS = ("initial-state", "whole-motion", "as-sampled")
#: What a bound of zero may be missed by, absolutely.
ZERO = 1e-10
#: An input that may be any function has as many pieces before some instant, and as many after it.
PIECES = 3
_STEP = 1e-6


@dataclass(frozen=True, eq=False)
class Setting:
    """The parameters of eq. (24), in SI units; `order` 3 is the triple integrator and 2 the double one."""

    T_c: float
    T_s: float
    d_hat_min: float
    v_max: Vector3
    a_max: Vector3
    j_max: Vector3
    theta_inverse: Array
    order: int = 3
    T_b: float | None = None

    @property
    def input_max(self) -> Array:
        """Return the bounds of the input, per axis."""
        return np.array(self.j_max if self.order == 3 else self.a_max, dtype=float)


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of reference trajectories from time 0, each with a window [start, start + T_c] and an instant in it."""

    position: Array
    velocity: Array
    acceleration: Array
    inputs: Array
    durations: Array
    start: Array
    instant: Array


def _periods(whole: float, part: float, complaint: str) -> int:
    count = round(whole / part)
    if count < 1 or abs(whole - count * part) > 1e-9 * whole:
        raise ValueError(complaint)
    return count


def windows(setting: Setting, reading: str) -> int:
    """Return how many windows there are: with `as-sampled` those of the periods for which bounds are given, else 1."""
    if reading not in READINGS or setting.order not in (2, 3):
        raise ValueError(f"no such reading or order: {reading}, {setting.order}")
    if reading != "as-sampled":
        return 1
    per_period = _periods(setting.T_s, setting.T_c, "T_s is no multiple of T_c")
    return per_period * _shape(setting)[0]


def _shape(setting: Setting) -> tuple[int, float, int]:
    """Return the T_s periods to simulate, the time between two instants at which X holds, and how many of these."""
    between = setting.T_s if setting.T_b is None else setting.T_b
    if between > setting.T_s:
        return _periods(between, setting.T_s, "T_b is no multiple of T_s"), between, 1
    return 1, between, _periods(setting.T_s, between, "T_s is no multiple of T_b")


def _advance(order: int, x: tuple[Array, Array, Array], u: Array, h: Array) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration a time `h` later, under the constant input `u`."""
    p, v, a = x
    half, sixth = h * h / 2, h * h * h / 6
    if order == 2:
        return p + v * h + u * half, v + u * h, a
    return p + v * h + a * half + u * sixth, v + a * h + u * half, a + u * h


def state_at(setting: Setting, pairs: Pairs, time: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (3 only; the input is not part of it) at one time per pair."""
    x = pairs.position, pairs.velocity, pairs.acceleration
    left = np.broadcast_to(np.asarray(time, dtype=float)[:, None, None], pairs.velocity.shape)
    for k in range(pairs.inputs.shape[-1]):
        h = np.clip(left, 0.0, pairs.durations[..., k])
        x = _advance(setting.order, x, pairs.inputs[..., k], h)
        left = left - pairs.durations[..., k]
    return x


def distance(setting: Setting, pairs: Pairs, time: Array) -> Array:
    """Return the scaled distance of the two UAVs of each pair, at one time per pair."""
    position = state_at(setting, pairs, time)[0]
    return np.asarray(np.linalg.norm((position[:, 0] - position[:, 1]) @ setting.theta_inverse.T, axis=1))


def dips(setting: Setting, pairs: Pairs) -> Array:
    """Return by how much each pair is closer than d̂_min at its instant."""
    return np.asarray(setting.d_hat_min - distance(setting, pairs, pairs.instant))


def _loads(setting: Setting, reading: str, pairs: Pairs) -> tuple[Array, Array]:
    """Return what X bounds, by pair, UAV, axis and kind, and the bound, by axis and kind: quantity ≤ bound."""
    high: list[Array] = []
    speeds: list[bool] = []

    def bound_velocity(most: Array, least: Array) -> None:
        high.extend((most, -least))
        speeds.extend((True, True))

    def bound_acceleration(a: Array) -> None:
        if setting.order == 3:
            high.extend((a, -a))
            speeds.extend((False, False))

    if reading == "whole-motion":
        x = pairs.position, pairs.velocity, pairs.acceleration
        bound_acceleration(x[2])
        for k in range(pairs.inputs.shape[-1]):
            u, h = pairs.inputs[..., k], pairs.durations[..., k]
            after = _advance(setting.order, x, u, h)
            velocities = [x[1], after[1]]
            if setting.order == 3:
                # the velocity turns where the acceleration is zero
                turn = np.clip(np.divide(-x[2], u, out=np.zeros_like(u), where=u != 0), 0.0, h)
                velocities.append(_advance(3, x, u, turn)[1])
            bound_velocity(np.maximum.reduce(velocities), np.minimum.reduce(velocities))
            bound_acceleration(after[2])
            x = after
    else:
        _, between, count = _shape(setting)
        for k in range(count + 1 if reading == "as-sampled" else 1):
            _, v, a = state_at(setting, pairs, np.full(len(pairs.start), k * between))
            bound_velocity(v, v)
            bound_acceleration(a)
    bounds = np.where(speeds, np.array(setting.v_max)[:, None], np.array(setting.a_max)[:, None])
    return np.stack(high, axis=-1), bounds


def excess(setting: Setting, reading: str, pairs: Pairs) -> Array:
    """Return by how much each pair misses a constraint of the reading: an input, X, or the distance at the ends."""
    ends = (pairs.start, pairs.start + setting.T_c)
    near = [setting.d_hat_min - distance(setting, pairs, end) for end in ends]
    inputs = (np.abs(pairs.inputs) - setting.input_max[:, None]).max(axis=(1, 2, 3))
    quantities, bounds = _loads(setting, reading, pairs)
    return np.asarray(np.maximum.reduce([*near, inputs, (quantities - bounds).max(axis=(1, 2, 3))]))


# --- where to put the pair: only the displacements of its motion matter


def displacements(setting: Setting, pairs: Pairs) -> tuple[Array, Array]:
    """Return a, b such that y, the scaled relative position at the instant, is y − a and y − b at the ends."""
    at = [state_at(setting, pairs, time)[0] for time in (pairs.instant, pairs.start, pairs.start + setting.T_c)]
    here, first, last = ((p[:, 0] - p[:, 1]) @ setting.theta_inverse.T for p in at)
    return here - first, here - last


def _unit(vectors: Array, otherwise: Array) -> Array:
    """Return the directions of vectors, and those given `otherwise` for vectors that are zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0, vectors, otherwise) / np.where(length > 0, length, 1.0)


def _across(directions: Array) -> Array:
    """Return a unit vector perpendicular to each of the directions."""
    least = np.eye(3)[np.abs(directions).argmin(axis=1)]
    return _unit(np.cross(directions, least), least)


def place(a: Array, b: Array, d: float) -> Array:
    """Return, row by row, the y nearest to 0 with ‖y − a‖ ≥ d and ‖y − b‖ ≥ d.

    It is 0, or the point of one sphere nearest to 0, or the point nearest to 0 of the circle in which the spheres
    meet: a distance to 0 has no other local minimum on a sphere or on a circle.
    """
    x_axis = np.broadcast_to(np.array([1.0, 0.0, 0.0]), a.shape)
    away_from_a = _unit(-a, _unit(-b, x_axis))
    away_from_b = _unit(-b, _unit(-a, x_axis))
    normal = _unit(a - b, x_axis)
    middle = (a + b) / 2
    across = middle - np.sum(middle * normal, axis=1, keepdims=True) * normal
    perpendicular = _across(normal)
    noise = np.linalg.norm(across, axis=1, keepdims=True) < 1e-12 * d
    towards = _unit(np.where(noise, perpendicular, across), perpendicular)
    towards = _unit(towards - np.sum(towards * normal, axis=1, keepdims=True) * normal, perpendicular)
    radius = np.sqrt(np.maximum(d**2 - np.sum((a - b) ** 2, axis=1, keepdims=True) / 4, 0.0))
    candidates = np.stack([np.zeros_like(a), a + d * away_from_a, b + d * away_from_b, middle - radius * towards])
    gap = np.minimum(np.linalg.norm(candidates - a, axis=2), np.linalg.norm(candidates - b, axis=2))
    norms = np.where(gap >= d * (1 - 1e-12), np.linalg.norm(candidates, axis=2), np.inf)
    return np.asarray(candidates[norms.argmin(axis=0), np.arange(len(a))])


def place_along(a: Array, b: Array, d: float, direction: Array) -> Array:
    """Return, row by row, the first y from 0 along `direction` (a unit vector) that is as far as `place` asks for."""
    leave: list[Array] = []
    enter: list[Array] = []
    for centre in (a, b):
        along = np.sum(centre * direction, axis=1)
        inside = along**2 - np.sum(centre**2, axis=1) + d**2
        half = np.sqrt(np.maximum(inside, 0.0))
        enter.append(np.where(inside > 0, along - half, np.inf))
        leave.append(np.where(inside > 0, along + half, -np.inf))
    t = np.zeros(len(a))
    for k in (0, 1, 0):
        t = np.where((enter[k] < t) & (t < leave[k]), leave[k], t)
    return t[:, None] * direction


def _put(setting: Setting, pairs: Pairs, y: Array) -> Pairs:
    """Move the first UAV of each pair so that the scaled relative position at the instant is `y`."""
    position = state_at(setting, pairs, pairs.instant)[0]
    wanted = np.linalg.solve(setting.theta_inverse, y.T).T
    moved = pairs.position.copy()
    moved[:, 0] += wanted - (position[:, 0] - position[:, 1])
    return replace(pairs, position=moved)


# --- pairs as vectors: velocities, accelerations, inputs, lengths of the pieces, where their halves meet, the instant


def _pieces(setting: Setting, reading: str) -> int:
    return _shape(setting)[0] if reading == "as-sampled" else 2 * PIECES


def _box(setting: Setting, reading: str) -> tuple[Array, Array, Array]:
    """Return the unit of each entry of a vector, and its bounds in that unit."""
    k = _pieces(setting, reading)
    state_a = np.array(setting.a_max) * (setting.order == 3)
    inputs = np.repeat(setting.input_max, k)
    motion = np.concatenate([np.tile(setting.v_max, 2), np.tile(state_a, 2), np.tile(inputs, 2)])
    lengths = np.ones(6 * k)
    units = np.concatenate([motion, lengths, [setting.T_c, setting.T_c]])
    shortest = lengths if reading == "as-sampled" else 0.02 * lengths
    low = np.concatenate([-(motion > 0).astype(float), shortest, [0.0, 0.0]])
    high = np.concatenate([(motion > 0).astype(float), lengths, [1.0, 1.0]])
    return units, low, high


def _decode(setting: Setting, reading: str, z: Array, window: Array) -> Pairs:
    """Return the pairs that vectors stand for; both UAVs start at 0."""
    n, k = len(z), _pieces(setting, reading)
    z = z * _box(setting, reading)[0]
    v, a, u, lengths, split, tau = np.split(z, np.cumsum([6, 6, 6 * k, 6 * k, 1]), axis=1)
    start = window * setting.T_c
    lengths = lengths.reshape(n, 2, 3, k)
    if reading == "as-sampled":
        durations = np.full((n, 2, 3, k), setting.T_s)
    else:
        before, after = lengths[..., :PIECES], lengths[..., PIECES:]
        before = before / before.sum(axis=-1, keepdims=True) * split[:, :, None, None]
        after = after / after.sum(axis=-1, keepdims=True) * (setting.T_c - split)[:, :, None, None]
        durations = np.concatenate([before, after], axis=-1)
    return Pairs(
        position=np.zeros((n, 2, 3)),
        velocity=v.reshape(n, 2, 3),
        acceleration=a.reshape(n, 2, 3),
        inputs=u.reshape(n, 2, 3, k),
        durations=durations,
        start=start,
        instant=start + tau[:, 0],
    )


def _random(setting: Setting, reading: str, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return random vectors and windows: often extreme values, one sign throughout, or the second UAV opposed."""
    k = _pieces(setting, reading)
    _, low, high = _box(setting, reading)
    z = rng.uniform(low, high, (count, len(low)))
    ends = slice(0, 12 + 6 * k)
    extreme = np.where(rng.random((count, ends.stop)) < rng.random((count, 1)), np.sign(z[:, ends]), z[:, ends])
    z[:, ends] = np.where(rng.random((count, 1)) < 0.75, extreme, z[:, ends])
    inputs = z[:, 12 : ends.stop].reshape(count, 2, 3, k)
    inputs = np.where(rng.random((count, 1, 1, 1)) < 0.4, inputs[..., :1], inputs)
    z[:, 12 : ends.stop] = inputs.reshape(count, -1)
    opposed = rng.random(count) < 0.5
    for first, last in ((0, 6), (6, 12), (12, ends.stop)):
        half = (first + last) // 2
        z[opposed, half:last] = -z[opposed, first:half]
    z[:, -2] = np.where(rng.random(count) < 0.5, 0.5, z[:, -2])
    z[:, -1] = np.where(rng.random(count) < 0.5, z[:, -2], z[:, -1])
    if reading == "as-sampled":
        _aim(setting, z, k, rng)
    z = np.clip(z, low, high)
    if reading == "whole-motion":
        _saturate(setting, z[: count // 2])
    return z, rng.integers(windows(setting, reading), size=count).astype(float)


def _aim(setting: Setting, z: Array, k: int, rng: np.random.Generator) -> None:
    """Change half of the vectors of sampled motions such that a velocity within bounds is reached after T_s."""
    chosen = rng.random(len(z)) < 0.5
    units, low, high = _box(setting, "as-sampled")
    first = slice(12, 12 + 6 * k, k)
    v0, u = z[:, :6] * units[:6], z[:, first] * units[first]
    v1 = rng.uniform(-1, 1, (len(z), 6)) * units[:6]
    v1 = np.where(rng.random((len(z), 1)) < 0.5, np.sign(v1) * units[:6], v1)
    where = slice(6, 12) if setting.order == 3 else first
    aimed = (v1 - v0) / setting.T_s - (u * setting.T_s / 2 if setting.order == 3 else 0.0)
    aimed = aimed / np.where(units[where] > 0, units[where], 1.0)
    z[chosen, where] = np.clip(aimed, low[where], high[where])[chosen]


def _saturate(setting: Setting, z: Array) -> None:
    """Change the inputs of whole motions so that what they drive, velocity or acceleration, stops at its bound."""
    pairs = _decode(setting, "whole-motion", z, np.zeros(len(z)))
    k = pairs.inputs.shape[-1]
    bound = np.array(setting.v_max if setting.order == 2 else setting.a_max)
    level = pairs.velocity if setting.order == 2 else pairs.acceleration
    for piece in range(k):
        u, h = pairs.inputs[..., piece], pairs.durations[..., piece]
        after = np.clip(level + u * h, -bound, bound)
        pairs.inputs[..., piece] = np.divide(after - level, h, out=np.zeros_like(h), where=h > 0)
        level = after
    units = np.where(setting.input_max > 0, setting.input_max, 1.0)[:, None]
    z[:, 12 : 12 + 6 * k] = np.clip(pairs.inputs / units, -1.0, 1.0).reshape(len(z), -1)


def _shrunk(setting: Setting, reading: str, z: Array, window: Array) -> Array:
    """Shrink the motion of each UAV along each axis until it respects its bounds, which are symmetric and convex."""
    n, k = len(z), _pieces(setting, reading)
    pairs = _decode(setting, reading, z, window)
    quantities, bounds = _loads(setting, reading, pairs)
    gauge = (quantities / np.maximum(bounds, ZERO)).max(axis=-1)
    # above 1 by rounding is not above 1
    shrink = 1.0 / np.where(gauge > 1.0 + 1e-15, gauge * (1.0 + 1e-15), 1.0)
    flat = shrink.reshape(n, 6)
    z = z.copy()
    z[:, : 12 + 6 * k] *= np.concatenate([flat, flat, np.repeat(flat, k, axis=1)], axis=1)
    return z


def random_pairs(setting: Setting, reading: str, count: int, seed: int) -> Pairs:
    """Return random feasible pairs, half of them placed as close as they can be at their instant."""
    rng = np.random.default_rng(seed)
    z, window = _random(setting, reading, count, rng)
    pairs = _decode(setting, reading, _shrunk(setting, reading, z, window), window)
    a, b = displacements(setting, pairs)
    direction = _unit(rng.normal(size=(count, 3)), np.eye(3)[np.zeros(count, dtype=int)])
    y = place_along(a, b, setting.d_hat_min, direction)
    y = np.where(rng.random((count, 1)) < 0.5, place(a, b, setting.d_hat_min), y)
    return _put(setting, pairs, y)


def random_dips(setting: Setting, reading: str, count: int, seed: int) -> Array:
    """Return the dips of random feasible pairs, each the largest found at 33 times of its window and its instant."""
    pairs = random_pairs(setting, reading, count, seed)
    times = [pairs.start + setting.T_c * fraction for fraction in np.linspace(0.0, 1.0, 33)]
    nearest = np.minimum.reduce([distance(setting, pairs, time) for time in (*times, pairs.instant)])
    return np.asarray(setting.d_hat_min - nearest)


# --- local search


def _depths(setting: Setting, pairs: Pairs, fraction: Array) -> Array:
    """Return the dips of pairs placed as close as they can be at these fractions of their windows."""
    pairs = replace(pairs, instant=pairs.start + setting.T_c * fraction)
    y = place(*displacements(setting, pairs), setting.d_hat_min)
    return np.asarray(setting.d_hat_min - np.linalg.norm(y, axis=1))


class _Search:
    """The ascent from one vector: linear programs in a box around it, which shrinks when they do not help."""

    def __init__(self, setting: Setting, reading: str, window: float) -> None:
        self.setting, self.reading, self.window = setting, reading, window
        _, self.low, self.high = _box(setting, reading)
        self.free = np.flatnonzero(self.high > self.low)

    def pairs(self, z: Array) -> Pairs:
        """Return the pairs that vectors stand for."""
        return _decode(self.setting, self.reading, z, np.full(len(z), self.window))

    def feasible(self, z: Array) -> tuple[Array, float]:
        """Return a vector with its motion made feasible and at its best instant, and the dip there."""
        z = _shrunk(self.setting, self.reading, z[None], np.array([self.window]))[0]
        copies = self.pairs(np.repeat(z[None], 129, axis=0))
        low, high, best, deepest = 0.0, 1.0, 0.5, -np.inf
        for _ in range(4):
            grid = np.linspace(low, high, 129)
            depths = _depths(self.setting, copies, grid)
            k = int(depths.argmax())
            if depths[k] > deepest:
                best, deepest = float(grid[k]), float(depths[k])
            low, high = float(grid[max(k - 1, 0)]), float(grid[min(k + 1, 128)])
        z[-1] = best
        return z, deepest

    def rows(self, z: Array) -> tuple[Array, Array, Array]:
        """Return the linear program at a vector: what to lower, and rows and right-hand sides that bound changes.

        Its variables are the changes of the free entries of the vector, and of y in units of d̂_min.
        """
        d, n = self.setting.d_hat_min, len(self.free)
        shifts = np.zeros((n, len(z)))
        shifts[np.arange(n), self.free] = _STEP
        around = self.pairs(np.concatenate([z[None], z + shifts, z - shifts]))
        centres = displacements(self.setting, around)
        y = place(centres[0][:1], centres[1][:1], d)[0]
        quantities, bounds = _loads(self.setting, self.reading, around)
        room = ((bounds - quantities) / np.where(bounds > 0, bounds, 1.0)).reshape(2 * n + 1, -1)
        bounded = (room[n + 1 :] - room[1 : n + 1]).T / (2 * _STEP)
        binding = np.abs(bounded).sum(axis=1) > 0
        rows = [np.concatenate([bounded, np.zeros((len(bounded), 3))], axis=1)[binding]]
        right = [np.maximum(room[0, binding], 0.0)]
        for centre in centres:
            gap = float(np.linalg.norm(y - centre[0]))
            outwards = (y - centre[0]) / gap
            moving = (centre[1 : n + 1] - centre[n + 1 :]) @ outwards / (2 * _STEP * d)
            rows.append(np.concatenate([moving, -outwards])[None])
            right.append(np.array([max(gap / d - 1, 0.0)]))
        aim = np.concatenate([np.zeros(n), y / np.linalg.norm(y)])
        return aim, np.concatenate(rows), np.concatenate(right)

    def climb(self, z: Array, steps: int) -> tuple[Array, float]:
        """Return the feasible vector that so many steps lead to, and its dip, which is no less than that of `z`."""
        radius, stale = 0.5, True
        z, best = self.feasible(z)
        for _ in range(steps):
            if radius < 1e-7 or best >= self.setting.d_hat_min:
                break
            if stale:
                aim, rows, right = self.rows(z)
            least = np.append(np.maximum(self.low - z, -radius)[self.free], np.full(3, -radius))
            most = np.append(np.minimum(self.high - z, radius)[self.free], np.full(3, radius))
            found = linprog(
                aim,
                A_ub=rows,
                b_ub=right,
                bounds=list(zip(least.tolist(), most.tolist(), strict=True)),
                options={"primal_feasibility_tolerance": 1e-10},
            )
            change = np.zeros(len(aim)) if found.x is None else np.asarray(found.x, dtype=float)
            hoped = -float(aim @ change) * self.setting.d_hat_min
            if hoped < 1e-8 * self.setting.d_hat_min:
                break
            moved = z.copy()
            moved[self.free] += change[:-3]
            moved, there = self.feasible(np.clip(moved, self.low, self.high))
            stale = there > best
            if there - best < 0.25 * hoped:
                radius *= 0.4
            elif there - best > 0.75 * hoped:
                radius = min(2 * radius, 2.0)
            if stale:
                z, best = moved, there
        return z, best


def _kicked(setting: Setting, reading: str, z: Array, rng: np.random.Generator) -> Array:
    """Return a vector with another motion along one axis."""
    k = _pieces(setting, reading)
    other, _ = _random(setting, reading, 2, rng)
    flat = np.concatenate([np.arange(12) % 3, np.arange(6 * k) // k % 3])
    chosen = np.flatnonzero(flat == rng.integers(3))
    z = z.copy()
    z[chosen] = other[rng.integers(2), chosen]
    return z


def best_pair(setting: Setting, reading: str, seed: int = 0, effort: int = 1) -> Pairs:
    """Return the feasible pair with the largest dip that a local search from the best random pairs found."""
    rng = np.random.default_rng(seed)
    z, window = _random(setting, reading, 4000 * effort, rng)
    z = _shrunk(setting, reading, z, window)
    pool = _decode(setting, reading, z, window)
    depths = np.maximum.reduce([_depths(setting, pool, f) for f in (z[:, -1], *map(np.asarray, (0.3, 0.5, 0.7)))])
    # the best start of each group: by window, by passing or turning back, and by chance
    a, b = displacements(setting, pool)
    searches = max(1, -(-2 * effort // windows(setting, reading)))
    group = 2 * (window * searches + rng.integers(searches, size=len(z))) + (np.sum(a * b, axis=1) > 0)
    starts = [int(np.flatnonzero(group == g)[depths[group == g].argmax()]) for g in np.unique(group)]
    queue = [(_Search(setting, reading, float(window[s])), z[s]) for s in sorted(starts, key=lambda s: -depths[s])]
    best, deepest, kicks = queue[0], -np.inf, (8 if reading == "as-sampled" else 3) * effort
    while deepest < setting.d_hat_min and (queue or kicks):
        if queue:
            search, start = queue.pop(0)
        else:
            search, start, kicks = best[0], _kicked(setting, reading, best[1], rng), kicks - 1
        improved, depth = search.climb(start, 30 + 10 * effort)
        if depth > deepest:
            best, deepest = (search, improved), depth
    pair = best[0].pairs(best[1][None])
    return _put(setting, pair, place(*displacements(setting, pair), setting.d_hat_min))


def best_dip(setting: Setting, reading: str, seed: int = 0, effort: int = 1) -> float:
    """Return the dip of `best_pair`: a lower bound of the largest dip."""
    return float(dips(setting, best_pair(setting, reading, seed, effort))[0])


# --- closed forms


def chord_dip(length: float, d: float) -> float:
    """Return the dip on a straight line between two points `length` apart and at least d from 0.

    The best chord has both ends at d, and its middle is √(d² − (length/2)²) from 0, or 0 when it can pass through.
    """
    return float(d - np.sqrt(max(d**2 - min(length / 2, d) ** 2, 0.0)))


def constant_velocity_dip(setting: Setting) -> float:
    """Return the largest dip when no UAV can accelerate.

    It is that of the longest chord; since the length is convex in the relative velocity, a corner of the box gives it.
    """
    corners = np.stack(np.meshgrid(*[(-2 * v, 2 * v) for v in setting.v_max]), axis=-1).reshape(-1, 3)
    longest = np.linalg.norm(corners @ setting.theta_inverse.T, axis=1).max() * setting.T_c
    return chord_dip(float(longest), setting.d_hat_min)


def collinear_distance(forth: Array, on: Array, d: float) -> Array:
    """Return the least distance after moving `forth` and before moving `on`, both along one line (either sign).

    With the line h from 0 and the position x on it, the ends are at x − forth and x + on. In passing (equal signs),
    h² = d² − ((forth + on)/2)² makes both ends tight and leaves √(d² − forth·on); where that h² is negative, and in
    turning back (opposite signs), h = 0 is best and the end that is nearer to x sets the distance.
    """
    reach = np.minimum(np.abs(forth), np.abs(on))
    passing = (forth * on > 0) & (np.abs(forth) + np.abs(on) <= 2 * d)
    return np.where(passing, np.sqrt(np.maximum(d**2 - forth * on, 0.0)), np.maximum(d - reach, 0.0))


def one_axis_dip(setting: Setting, reading: str, axis: int) -> float:
    """Return the largest dip, of order 2 and with T_b = T_s, when the bounds of the other two axes are zero.

    The UAVs move relative to each other with speeds up to V and accelerations up to W, and may be offset across.
    *Passing*: a chord as long as possible. With `initial-state` V and W all along; otherwise V all along.
    *Turning back*: as far forth as there is time to come back. Symmetric about the middle of the window,
    v = W·(T/2 − t), so W·T²/8; unless that is too fast at the ends: with `initial-state`, W before −W, such that all
    time is used; with `whole-motion`, V until −W takes it to −V; with `as-sampled`, the straight line of the velocity
    keeps within V over T_s, which limits W by the time from the middle of the window to the farther end of T_s.
    """
    t, d = setting.T_c, setting.d_hat_min
    scale = float(np.linalg.norm(setting.theta_inverse[:, axis]))
    v, w = 2 * setting.v_max[axis], 2 * setting.a_max[axis]
    longest = v * t
    turn = w * t**2 / 8
    if reading == "initial-state":
        longest += w * t**2 / 2
        if v < w * t / 2:
            # ∫(T − s)·u ds + V·T = 0 fixes when the input changes sign
            change = t - np.sqrt(t**2 / 2 + v * t / w)
            turn = v * change + w * change**2 / 2 + (v + w * change) ** 2 / (2 * w)
    elif reading == "whole-motion":
        if v < w * t / 2:
            turn = v * t / 2 - v**2 / (2 * w)
    else:
        middles = t * (np.arange(windows(setting, reading)) + 0.5)
        turn = np.minimum(w, v / np.maximum(middles, setting.T_s - middles)).max() * t**2 / 8
    return max(chord_dip(scale * longest, d), min(scale * float(turn), d))
