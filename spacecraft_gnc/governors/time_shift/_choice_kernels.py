"""Kernels that enumerate combinations of shifts; `choice` documents them.

The combinations are the leaves of a tree, one craft a level, shifts in ascending order; a branch
ends where a pair fails. So ties go to the lowest shifts, the first craft's first.
"""

from __future__ import annotations

import numpy as np

from spacecraft_gnc._kernels import kernel, unlocked_kernel


@unlocked_kernel
def cheapest(able, masks, apart, counted, cost, bound, shifts):
    """Least J of the admissible combinations, and their number; sets ``shifts`` (n,).

    able (n, p), masks (n, n, p, p); apart (p, p): W of a pair; counted (n,): craft in W; cost
    (n, p): Omega of each. With a finite ``bound`` only what is cheaper is looked for and counted.
    Returns the bound, and leaves ``shifts``, if there is none.
    """
    n, p = able.shape
    at, before = np.full(n, -1), np.zeros(n)
    best, count, level, is_complete = bound, 0, 0, bound == np.inf
    while level >= 0:
        at[level] += 1
        a = at[level]
        if a == p:
            level -= 1
            continue
        if not able[level, a]:
            continue
        total, fits = before[level] + cost[level, a], True
        for i in range(level):
            if not masks[i, level, at[i], a]:
                fits = False
                break
            if counted[i] and counted[level]:
                total += apart[at[i], a]
        if not fits or (not is_complete and total >= best):
            continue
        if level < n - 1:
            level += 1
            before[level], at[level] = total, -1
            continue
        count += 1
        if total < best:
            best = total
            shifts[:] = at
    return best, count


@kernel
def cost_of(shifts, apart, counted, cost):
    """W and Omega of a combination (n,)."""
    W, Omega = 0.0, 0.0
    for j in range(shifts.shape[0]):
        if counted[j]:
            Omega += cost[j, shifts[j]]
            for i in range(j):
                if counted[i]:
                    W += apart[shifts[i], shifts[j]]
    return W, Omega


@unlocked_kernel
def least_violating(single, double, apart, counted, cost, able, shifts):
    """Least largest violation of a combination; sets ``shifts`` (n,), of equal ones the cheapest.

    single (n, p), double (n, n, p, p): violations, at most 0 where everything is kept.
    """
    n, p = single.shape
    at, before, until = np.full(n, -1), np.zeros(n), np.zeros(n)
    best, price, level = np.inf, np.inf, 0
    while level >= 0:
        at[level] += 1
        a = at[level]
        if a == p:
            level -= 1
            continue
        if not able[level, a]:
            continue
        worst, total = max(until[level], single[level, a]), before[level] + cost[level, a]
        for i in range(level):
            worst = max(worst, double[i, level, at[i], a])
            if counted[i] and counted[level]:
                total += apart[at[i], a]
        if worst > best or (worst == best and total >= price):
            continue
        if level < n - 1:
            level += 1
            before[level], until[level], at[level] = total, worst, -1
            continue
        best, price = worst, total
        shifts[:] = at
    return best


@unlocked_kernel
def nearest(able, masks, apart, counted, cost, phases, distances, is_whole, most, shifts):
    """Least distance, at most ``most``, of the admissible combinations, and their number.

    distances (c,): of the `class_of` each formation of the ``counted`` craft, -1: none. Sets
    ``shifts`` (n,), of equally near ones the cheapest. Returns -1 if all are further away.
    """
    n, p = able.shape
    at, before = np.full(n, -1), np.zeros(n)
    best, price, count, level = most + 1, np.inf, 0, 0
    while level >= 0:
        at[level] += 1
        a = at[level]
        if a == p:
            level -= 1
            continue
        if not able[level, a]:
            continue
        total, fits = before[level] + cost[level, a], True
        for i in range(level):
            if not masks[i, level, at[i], a]:
                fits = False
                break
            if counted[i] and counted[level]:
                total += apart[at[i], a]
        if not fits:
            continue
        if level < n - 1:
            level += 1
            before[level], at[level] = total, -1
            continue
        count += 1
        far = distances[class_of(at, counted, phases, p, is_whole)]
        if far >= 0 and (far < best or (far == best and total < price)):
            best, price = far, total
            shifts[:] = at
    return (best if best <= most else -1), count


@kernel
def class_of(shifts, counted, phases, p, is_whole):
    """Class of the formation of the ``counted`` craft: the digits of `_passage_kernels`.

    ``is_whole``: the shifts of all of them are the digits, not the differences of places.
    """
    number, first = 0, -1
    for i in range(shifts.shape[0]):
        if counted[i] and is_whole:
            number = number * p + shifts[i]
        elif counted[i] and first < 0:
            first = i
        elif counted[i]:
            ahead = phases[i] + shifts[i] - phases[first] - shifts[first]
            number = number * p + ahead % p
    return number
