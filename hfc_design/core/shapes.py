"""Types of numbers, tables and arrays, each named once. Never imports JAX."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

#: A number of one machine: a float in the runtime, an array over individuals with NumPy, a value
#: being traced in the simulator. No type of Python's says what these three have in common.
Scalar: TypeAlias = Any
#: A truth about ``Scalar``s, of the same three kinds.
Truth: TypeAlias = Any
#: (..., steps) numbers, one a control sample: of NumPy or JAX, or being traced.
Series: TypeAlias = Any
#: What only its kind of controller knows: its numbers, and what it remembers.
Gains: TypeAlias = Any
Memory: TypeAlias = Any
#: What only a drive knows: the record of its parameters, what a step needs of them, its state.
Parameters: TypeAlias = Any
State: TypeAlias = Any
#: A table of a TOML or JSON file: what its values are only who reads them knows.
Json: TypeAlias = dict[str, Any]

Degrees: TypeAlias = Sequence[Scalar]  # (7,) of a value in the terms of an input
Triangles: TypeAlias = Sequence[Sequence[Scalar]]  # (7, 3) left, centre, right
RuleTable: TypeAlias = Sequence[Sequence[Scalar]]  # (7, 7) singletons [row][column]

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]  # numbers of elements, from 0 on
