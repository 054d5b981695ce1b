"""Drives whose position is a place in metres, as tests write them."""

from plants import Drive, only_positive


def along_a_line(name, command, parameters, state, step, **changes):
    """A drive with a ``command`` in this unit, whose state has a place and a speed."""
    units = {"error": "m", "error_rate": "m/s", "command": command, "load": "N", "speed": "m/s"}
    return Drive(
        **{
            "name": name,
            "parameters": parameters,
            "fault": only_positive(parameters),
            "units": units,
            "initial_state": lambda zero: state(*[zero] * len(state._fields)),
            "step": step,
            "signals": lambda p, x: {"speed": x.speed},
            "position": "place",
            "velocity": "speed",
            "encoders": {"place": "speed"},
        }
        | changes
    )
