"""Structured Text read by two parsers of IEC 61131-3: tree-sitter-iec61131-3-st and blark.

No compiler is on a registry that is reachable here: that the text also computes what it should is
tested by tests/formats/test_structured_text.py, which executes it.
"""

import subprocess
from pathlib import Path

import pytest
from wiring import design

from hfc_design.formats import FORMATS

pytestmark = pytest.mark.interop
PYTHON = Path(__file__).parents[2] / ".venv-st" / "bin" / "python"
READERS = {
    "tree-sitter": """
import sys, tree_sitter, tree_sitter_iec61131_3_st as grammar
parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
sys.exit(parser.parse(open(sys.argv[1], "rb").read()).root_node.has_error)
""",
    "blark": """
import sys
from blark.parse import parse_source_code
result = parse_source_code(open(sys.argv[1]).read())
result.transform()
sys.exit(result.exception is not None)
""",
}


@pytest.fixture(params=READERS)
def reads(request):
    if not PYTHON.exists():
        pytest.skip("the parsers are not installed; make interop installs them")
    command = [str(PYTHON), "-c", READERS[request.param]]
    return lambda file: subprocess.run([*command, str(file)], check=False).returncode == 0


@pytest.mark.parametrize("name", ["random-2", "jee-koren-2004-aflc", "jee-koren-2004-pid"])
def test_the_parser_finds_no_error(name, reads, tmp_path):
    file = tmp_path / "design.st"
    FORMATS["st"].write(design(name), file)
    assert reads(file)


def test_the_parser_finds_an_error_where_there_is_one(reads, tmp_path):
    file = tmp_path / "design.st"
    FORMATS["st"].write(design("pd-only"), file)
    file.write_text(file.read_text().replace("command :=", "command := *"))
    assert not reads(file)
