"""Built-in designs with other values as files."""

import json

from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design


def written(path, like="pd-only", changes=None, **parts):
    """A built-in design with other values as a file."""
    data = json.loads(design_json(load_design(like, changes)))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data | parts))
    return str(path)
