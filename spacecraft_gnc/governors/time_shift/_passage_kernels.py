"""Kernels that find passages between parked formations; `passages` documents them.

f: places on the motion where craft are parked, g: places commanded from then on, both at one
instant. A class is the differences of places to the first craft's, as one number of n - 1 digits.
"""

from __future__ import annotations

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel, unlocked_kernel
from spacecraft_gnc.governors.time_shift._prediction_kernels import (
    keeps_apart,
    keeps_both,
    largest,
    spread,
)


@unlocked_kernel
def transfers(natural, path, m, pushes, rows, most, able, positions):
    """Set ``able`` (p, p) [f, g] where a parked craft keeps its delta-v, and positions of each."""
    p, r = natural.shape[0], rows.shape[2]
    e, pushed = np.empty(6), np.empty((3, pushes.shape[2]))
    for f in range(p):
        for g in range(p):
            for j in range(6):
                e[j] = natural[f, j] - natural[g, j]
            spread(pushes, e, pushed)
            able[f, g] = largest(pushed)[0] <= most
            spread(rows, e, positions[f, g])
            for c in range(3):
                for q in range(r):
                    positions[f, g, c, q] += path[c, g * m + q]


@unlocked_kernel
def joint_transfers(able, positions, path, m, least, cosine, joint):
    """Set ``joint`` (p, p, p, p) [f, g, f', g'] where two parked craft keep all they have to."""
    p = able.shape[0]
    for f in range(p):
        for g in range(p):
            for f2 in range(p if able[f, g] else 0):
                for g2 in range(p):
                    if f2 < f or (f2 == f and g2 < g):  # the same pair, the other way round
                        joint[f, g, f2, g2] = joint[f2, g2, f, g]
                    elif able[f2, g2]:
                        joint[f, g, f2, g2] = keeps_both(
                            positions[f, g], positions[f2, g2], path, g * m, g2 * m, least, cosine
                        )


@inner_kernel
def is_kept(joint, places):
    """Whether a formation parked at these places (n,) keeps all constraints."""
    for j in range(places.shape[0]):
        for i in range(j):
            if joint[places[i], places[i], places[j], places[j]] == 0:
                return False
    return True


@inner_kernel
def mark_last(joint, places, at, common, reached):
    """Mark the classes reached with the last craft, given the places ``at`` of all others."""
    p, n = joint.shape[0], places.shape[0]
    f, g0, number = places[n - 1], at[0], 0
    for i in range(1, n - 1):
        number = number * p + (at[i] - g0) % p
    common[:] = joint[places[0], g0, f]
    for i in range(1, n - 1):
        row = joint[places[i], at[i], f]
        for g in range(p):
            common[g] &= row[g]
    target, end = reached[number * p : (number + 1) * p], p - g0
    for j in range(end):  # the difference j is that of the place g0 + j, and round the period
        target[j] |= common[g0 + j]
    for j in range(g0):
        target[end + j] |= common[j]


@inner_kernel
def mark_reached(joint, able, places, reached):
    """Mark the classes (c,) that one transition leads to from places (n,) at one instant."""
    p, n = able.shape[0], places.shape[0]
    at, common, level = np.full(n, -1), np.zeros(p, dtype=np.uint8), 0
    while level >= 0:
        at[level] += 1
        g = at[level]
        if g == p:
            level -= 1
            continue
        fits = able[places[level], g]
        for i in range(level):
            fits = fits and joint[places[i], at[i], places[level], g] != 0
        if not fits:
            continue
        if level == n - 2:
            mark_last(joint, places, at, common, reached)
        else:
            level += 1
            at[level] = -1


@unlocked_kernel
def mark_edges(joint, able, n, edges):
    """Set ``edges`` (c, c) [from, to] between the parked formations of n craft."""
    p = able.shape[0]
    places = np.zeros(n, dtype=np.int64)
    for number in range(edges.shape[0]):
        for s in range(p):
            digits = number
            for i in range(n - 1, 0, -1):
                places[i] = (s + digits % p) % p
                digits //= p
            places[0] = s
            if not is_kept(joint, places):
                break  # nor at any other instant: a flight of p steps passes all of them
            mark_reached(joint, able, places, edges[number])


@unlocked_kernel
def mark_clear(positions, drift, m, least, clear):
    """Set ``clear`` (p, p, p) [s, f, g] where a craft keeps away from a lost one that drifts.

    s: steps from now at which it, parked at f, is commanded to g. ``drift`` (3, p m + r).
    """
    p, r = positions.shape[0], positions.shape[3]
    for s in range(p):
        lost = drift[:, s * m : s * m + r]
        for f in range(p):
            for g in range(p):
                if clear[s, f, g]:
                    clear[s, f, g] = keeps_apart(positions[f, g], lost, least)


@inner_kernel
def mark_shifts(joint, able, clear, s, places, origins, reached):
    """Mark the shifts, as numbers of n digits, that one transition leads to at one instant.

    origins (n,): places of each craft without a shift.
    """
    p, n = able.shape[0], places.shape[0]
    at, level = np.full(n, -1), 0
    while level >= 0:
        at[level] += 1
        g = at[level]
        if g == p:
            level -= 1
            continue
        fits = able[places[level], g] and clear[s, places[level], g]
        for i in range(level):
            fits = fits and joint[places[i], at[i], places[level], g] != 0
        if not fits:
            continue
        if level < n - 1:
            level += 1
            at[level] = -1
            continue
        number = 0
        for i in range(n):
            number = number * p + (at[i] - origins[i]) % p
        reached[number] = 1


@unlocked_kernel
def mark_edges_around(joint, able, clear, step, phases, edges, goals):
    """Set ``edges`` (c, c) between the shifts of n craft, and ``goals`` (c,): all equal.

    As `mark_edges`, but a lost craft makes a difference between shifts that differ by a common one.
    """
    p, n = able.shape[0], phases.shape[0]
    shifts, origins = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for number in range(edges.shape[0]):
        digits, is_goal, is_parked = number, True, True
        for i in range(n - 1, -1, -1):
            shifts[i] = digits % p
            digits //= p
            is_goal = is_goal and shifts[i] == shifts[n - 1]
        for s in range(p):
            places = (step + s + phases + shifts) % p
            is_parked = is_parked and is_kept(joint, places)
            for f in places:
                is_parked = is_parked and clear[s, f, f]
        if not is_parked:
            continue
        goals[number] = is_goal
        for s in range(p):
            origins[:] = (step + s + phases) % p
            places = (origins + shifts) % p
            mark_shifts(joint, able, clear, s, places, origins, edges[number])


@kernel
def count_transitions(edges, goals, distance):
    """Set ``distance`` (c,) to the fewest transitions to one of the ``goals`` (c,); -1: none."""
    count = edges.shape[0]
    queue, begin, end = np.zeros(count, dtype=np.int64), 0, 0
    distance[:] = -1
    for number in range(count):
        if goals[number]:
            distance[number] = 0
            queue[end] = number
            end += 1
    while begin < end:
        to = queue[begin]
        begin += 1
        for number in range(count):
            if distance[number] < 0 and edges[number, to] != 0:
                distance[number] = distance[to] + 1
                queue[end] = number
                end += 1
