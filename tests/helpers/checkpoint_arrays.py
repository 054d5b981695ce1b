"""Forged checkpoints whose arrays lie: other members, headers, shapes, types, values and texts.

Each forger gives a whole file of the arrays of a checkpoint; as a zip file it is right.
"""

import json

import numpy as np
from checkpoint_files import npy, plain, replaced, zipped

HEADERS = [
    "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "(" * 3000 + "1" + ")" * 3000 + ",)}",
    "__import__('os').system('true')",
    "{'descr': '<f8', 'fortran_order': False}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), 'more': 1}",
    "{'descr': '<f8', 'fortran_order': 2, 'shape': (3,)}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (3L,)}",
    "{'descr': ('<f8', (3,)), 'fortran_order': False, 'shape': ()}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': [3]}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "9" * 5000 + ",)}",
    "{'descr': '<U999999999', 'fortran_order': False, 'shape': (3,)}",
    "{'descr': '<U0', 'fortran_order': False, 'shape': (999999999999,)}",
    "{'descr': '|V0', 'fortran_order': False, 'shape': (999999999999,)}",
    "{'descr': '\xe9', 'fortran_order': False, 'shape': ()}",
    "\0" * 100,
    "[" * 9000,
    " " * 20_000,
]
SHAPES = [(10**12,), (2**62, 2**62), (-3,), (-1, -3), (0,), (2**63,), (3, 0), (True,), ()]
TYPES = ["O", ">f8", "<f16", "<c16", "<M8[s]", "|V8", "|S8", "<U8", "|b1", "<i8", "<u8"]
NAMES = ["../x", "/etc/x", "a/b", "", ".", "generation", "\0", "x" * 60_000, "\u202e", "state"]
TEXTS = ["", "[]", "{}", "[" * 3000, "5", '{"a": {}}', '[["a", "b", "c"]]', "\ud800", "1" * 5000]
NUMBERS = [-1, -(2**62), 2**62, 0, 7, 3.0, np.nan, np.inf, True, "3", b"3", [3], [[3, 3]], 3j]


def another_member(arrays, draw):
    name = draw.choice(NAMES)
    return zipped([*replaced(arrays), (f"{name}{draw.choice(['.npy', '', '.exe'])}", plain(1.0))])


def another_name(arrays, draw):
    members = replaced(arrays)
    k = draw.randrange(len(members))
    name = draw.choice([name for name in NAMES if f"{name}.npy" != members[k][0]])
    return zipped([*members[:k], (f"{name}.npy", members[k][1]), *members[k + 1 :]])


def one_less(arrays, draw):
    members = replaced(arrays)
    del members[draw.randrange(len(members))]
    return zipped(members)


def some_twice(arrays, draw):
    members = replaced(arrays)
    return zipped([*members, draw.choice(members)])


def another_header(arrays, draw):
    key = draw.choice([*arrays])
    data = np.asarray(arrays[key]).tobytes()
    return zipped(replaced(arrays, **{key: npy(0, 0, data, header=draw.choice(HEADERS))}))


def another_size(arrays, draw):
    key = draw.choice([key for key in arrays if np.size(arrays[key]) > 1])
    own = np.asarray(arrays[key])
    return zipped(replaced(arrays, **{key: npy(own.dtype.str, draw.choice(SHAPES), own.tobytes())}))


def another_type(arrays, draw):
    """Its bytes told to be of another type, or its numbers turned into it."""
    key = draw.choice(sorted(arrays.keys() - {"format", "made_by"}))
    own, descr = np.asarray(arrays[key]), draw.choice(TYPES)
    if own.dtype.str == descr or draw.random() < 0.3:
        told = draw.choice(["|O", [("a", "<f8"), ("b", "<i8")], ("<f8", (2,)), "<f4"])
        return zipped(replaced(arrays, **{key: npy(told, own.shape, own.tobytes())}))
    try:
        with np.errstate(all="ignore"):
            other = np.zeros(own.shape, descr) if descr == "|V8" else own.astype(descr)
    except (ValueError, TypeError):
        other = own.astype("O")
    data = other.dumps() if other.dtype == object else other.tobytes()
    return zipped(replaced(arrays, **{key: npy(descr, own.shape, data)}))


def another_shape(arrays, draw):
    key = draw.choice([key for key in arrays if np.ndim(arrays[key]) and np.size(arrays[key]) > 1])
    own = arrays[key]
    changes = [own[None], own[:-1], np.concatenate([own, own]), own[..., None], own[:0]]
    return zipped(replaced(arrays, **{key: draw.choice(changes)}))


def fewer_rows(arrays, draw):
    """In all arrays of a record, so that they agree."""
    group = draw.choice(["history.", "state.", "archive."])
    own = {k: v for k, v in arrays.items() if k.startswith(group) and np.ndim(v)}
    rows = draw.choice([slice(0), slice(1), slice(-1), slice(None, None, 2)])
    less = {key: array[rows] for key, array in own.items()}
    if all(len(less[key]) == len(own[key]) for key in own):
        return fewer_rows(arrays, draw)
    return zipped(replaced(arrays, **less))


def another_generation(arrays, draw):
    value = draw.choice(NUMBERS)
    done = int(arrays["generation"])
    return zipped(replaced(arrays, generation=np.array(value if value != done else -done)))


def another_value(arrays, draw):
    """One that no search has: not a number, or far out of its range."""
    chosen = [k for k in arrays if k.startswith(("archive.", "state."))]
    chosen = [k for k in chosen if not k.endswith(("damping", "median"))]
    key = draw.choice([*chosen, "history.best"])
    other = arrays[key].copy()
    places = np.argwhere(np.ones(other.shape)) if other.size else [()]
    place = tuple(draw.choice(list(places)))
    if other.dtype.kind == "f":
        if ".population." in key:  # of one that has not failed
            score = arrays[key.split(".population.")[0] + ".score"]
            alive = np.flatnonzero(np.isfinite(score))
            place = (draw.choice(list(alive)), *place[1:])
        other[place] = np.inf if key == "history.best" else draw.choice([np.nan, np.inf])
    else:
        other[place] = draw.choice([-1, 10**10, -(2**63), 2**63 - 1, 10**5])
    return zipped(replaced(arrays, **{key: other}))


def another_text(arrays, draw):
    key = draw.choice(["format", "made_by"])
    text = draw.choice(TEXTS)
    values = [np.array([text, text]), np.array(text), np.zeros(5), np.array(b"x"), np.arange(10**5)]
    value = draw.choice(values)
    try:
        return zipped(replaced(arrays, **{key: value}))
    except UnicodeEncodeError:
        return zipped(replaced(arrays, **{key: npy("<U1", (), b"\0\xd8\0\0")}))


def made_by_another(arrays, draw):
    told = json.loads(str(arrays["made_by"]))
    key = draw.choice([*told])
    other = draw.choice([{}, None, 5, "another", "\x1b[2J", [], "x" * 10**6])
    changed = {k: v for k, v in told.items() if k != key} if other is None else {**told, key: other}
    return zipped(replaced(arrays, made_by=np.array(json.dumps(changed))))


#: Those of which every file has to be refused, and those that may as well change nothing.
REFUSED = [another_member, another_name, one_less, some_twice, another_header, another_size]
REFUSED += [another_shape, fewer_rows, another_generation, another_value, another_text]
REFUSED += [made_by_another]
EITHER = [another_type]
