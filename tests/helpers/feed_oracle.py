"""Plain transcriptions of the two papers' controllers, with loops and ifs, and random errors."""

import numpy as np

#: JK04 Table 2 as printed; * is "not considered".
TABLE_2 = """
-1 0 0 0 1 2 2
-1 -1 0 0 1 1 2
-2 -1 -1 0 0 1 1
* * * 0 * * *
1 1 0 0 -1 -1 -2
2 1 1 0 0 -1 -1
2 2 1 0 0 0 -1
"""
INDEX = [[0 if x == "*" else int(x) for x in row.split()] for row in TABLE_2.split("\n") if row]


def triangle(terms, k, u):
    """JK04 eq. 1, the outermost terms saturated at 1."""
    left, centre, right = terms[k]
    if u < centre:
        if k == 0:
            return 1.0
        return (u - left) / (centre - left) if u > left else 0.0
    if k == len(terms) - 1:
        return 1.0
    return (right - u) / (right - centre) if u < right else 0.0


def output(error_terms, change_terms, table, e, de):
    above = below = 0.0
    for i in range(len(error_terms)):
        for j in range(len(change_terms)):
            weight = triangle(error_terms, i, e) * triangle(change_terms, j, de)
            above += weight * table[i][j]
            below += weight
    return above / below if below else 0.0


def verdict_jk04(e, p, c, u0):
    """(contract?, sign of the singleton's move) of JK04 Appendix B."""
    same = abs(c - u0) < 1e-4
    if e > 0 and p > 0:  # (I)
        return (True, -1) if c > u0 or same else (False, 0)
    if e > 0 and p < 0:  # (II)
        return (False, 0) if c > u0 and not same else (True, +1)
    if e < 0 and p > 0:  # (III)
        return (False, 0) if c > u0 and not same else (True, +1)
    return (True, -1) if c > u0 or same else (False, 0)  # (IV)


def verdict_jk95(e, p, c, u0):
    """The same of JK95's table."""
    larger = c > u0 and abs(c - u0) >= 1e-4
    if e > 0 and p > 0:
        return (True, -1) if larger else (False, 0)
    if e > 0 and p < 0:
        return (True, +1) if larger else (False, 0)
    if e < 0 and p > 0:
        return (False, 0) if larger else (True, +1)
    return (True, -1) if larger else (False, 0)


class Adaptive:
    """The whole controller; ``sectors`` is (k1_max, k2_max), with a curve behind them, or None.

    With ``narrows_zero`` the rules of ZR are narrowed when the error leaves it.
    """

    def __init__(
        self,
        error_terms,
        change_terms,
        table,
        steps,
        verdict,
        sectors,
        overlaps=None,
        narrows_zero=False,
    ):
        self.a = [list(t) for t in error_terms]
        self.b = [list(t) for t in change_terms]
        self.c = [list(row) for row in table]
        self.first = [list(row) for row in table]
        self.steps, self.verdict, self.sectors = steps, verdict, sectors
        self.overlaps = overlaps or steps[:2]
        self.narrows_zero = narrows_zero
        self.e = self.de = self.u0 = 0.0

    def step(self, e):
        self.adapt(e)
        self.e, self.de = e, e - self.e
        self.u0 = output(self.a, self.b, self.c, self.e, self.de)
        return self.u0

    def adapt(self, e):
        k_a, k_b, k_c = self.steps
        degrees = [triangle(self.a, y, e) for y in range(7)]
        now = 3
        for y in (2, 4, 1, 5, 0, 6):
            if degrees[y] > degrees[now] + 1e-4:
                now = y
        moves_a, moves_b, moves_c = [0] * 7, [0] * 7, {}
        for i in range(7):
            for j in range(7):
                if triangle(self.a, i, self.e) < 1e-4 or triangle(self.b, j, self.de) < 1e-4:
                    continue
                p = INDEX[i][now]
                if self.narrows_zero and i == 3 and now != 3 and self.e != 0:
                    moves_a[i] += 1
                    moves_b[j] += 1
                if p == 0 or self.e == 0:
                    continue
                contract, sign = self.verdict(self.e, p, self.c[i][j], self.u0)
                moves_a[i] += abs(p) if contract else -abs(p)
                moves_b[j] += abs(p) if contract else -abs(p)
                moves_c[i, j] = sign * k_c * abs(p)
        for (i, j), move in moves_c.items():
            self.c[i][j] += move
        self.a = narrowed(self.a, moves_a, k_a, self.overlaps[0])
        self.b = narrowed(self.b, moves_b, k_b, self.overlaps[1])
        if self.sectors:
            self.bound()

    def bound(self):
        k1, k2, *curve = self.sectors
        steepest = 0.0
        for i in range(7):
            if i == 3:
                continue
            edge = self.a[i - 1][2] if i > 3 else self.a[i + 1][0]
            far = k1 * edge
            self.c[i][3] = min(max(self.c[i][3], min(0, far)), max(0, far))
            steepest = max(steepest, self.c[i][3] / edge)
        if curve:
            k2 = min(k2, np.interp(steepest, *np.transpose(curve[0])))
        for i in range(7):
            if i == 3:
                continue
            own = self.c[i][3]
            for j in range(7):
                if j == 3:
                    continue
                value, start = self.c[i][j], self.first[i][j]
                positive = start > 0 or (start == 0 and i > 3)
                value = max(value, 0.0) if positive else min(value, 0.0)
                far = own + k2 * (self.b[j - 1][2] if j > 3 else self.b[j + 1][0])
                self.c[i][j] = min(max(value, min(own, far)), max(own, far))


def narrowed(terms, moves, size, overlap):
    new = [list(t) for t in terms]
    for k in range(7):
        if k > 0:
            new[k][0] += size * moves[k]
        if k < 6:
            new[k][2] -= size * moves[k]
    for k in range(6):
        low, high = terms[k][1], terms[k + 1][1]
        right = min(max(new[k][2], low), high)
        left = min(max(new[k + 1][0], low), high)
        if right - left < overlap:
            middle = (right + left) / 2
            middle = min(max(middle, low + overlap / 2), high - overlap / 2)
            right, left = middle + overlap / 2, middle - overlap / 2
        new[k][2], new[k + 1][0] = right, left
    return new


def errors(count, seed):
    """Whole BLUs: swings of all sizes, rests and jumps."""
    random = np.random.default_rng(seed)
    swing = 26 * np.sin(np.cumsum(random.uniform(0.0, 0.5, count))) * random.uniform(0, 1, count)
    jump = random.integers(-40, 41, count) * (random.uniform(size=count) < 0.05)
    return np.rint(swing + jump + random.normal(0, 2, count)).tolist()
