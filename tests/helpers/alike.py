"""Built-in designs whose axes all have the same controller: formats write it as one."""

from hfc_design.files.design import builtin_designs, named_design

ALIKE = [name for name in builtin_designs() if named_design(name).kind.axes is None]
