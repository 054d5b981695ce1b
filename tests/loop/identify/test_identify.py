"""``hfc identify`` of a plant of one's own that cannot be replayed."""

import os
import sys

from moved_masses import FORCE, moved, write
from sledge import MODULE, hfc


def test_a_plant_that_branches_is_refused_in_a_line(own_plugins, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)
    write("log.csv", "time_s,place_m,command_N", moved(5.0, 9.0), FORCE)
    found = hfc("identify", "log.csv", "--plant", "mine:BRANCHING")
    assert found.exit_code == 2
    last = found.stderr.splitlines()[-1]
    assert last.startswith("hfc: plant 'sledge' cannot be replayed: in mine.py, line ")
    assert last.endswith("(TracerBoolConversionError)")
    assert "Traceback" not in found.output
    assert set(os.listdir()) <= {"__pycache__", "log.csv", "mine.py"}
