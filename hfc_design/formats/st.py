"""``--to st``: a design as a function block, and all one needs to trust it."""

from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.fcl import real
from hfc_design.formats.flash import readme
from hfc_design.formats.flash.folder import page_of_axes, table
from hfc_design.formats.flash.vectors import vectors
from hfc_design.formats.writing import Content, Format, check_names, rendered, signal_units


def with_vectors(design: Design, files: dict[str, str]) -> dict[str, Content]:
    """The block in whatever form, with a page, vectors and a program that runs them.

    Raises:
        UserError: the kind has no such code, or a name is none of the language.
    """
    _, block = code.block_values(design)
    program, held = f"{block['block']}_check", block["held"]
    check_names("st", [block["block"], program, "controller"], code.CLASH)
    # Where an adaptation is left out, the vectors are those of what the block does.
    same = design if held is None else design.model_copy(update={"controller": held})
    found = vectors(same)
    values = readme.values(same, found) | {
        "name": block["block"],
        "program": program,
        "files": list(files),
        "inputs": list(block["signals"]),
        "expected": [float(command) for (command,) in found.commands],
        "columns": [list(map(float, column)) for column in zip(*found.inputs, strict=True)],
        "resets": [k for k, reset in enumerate(found.resets) if reset],
        "left_out": held is not None,
        "remembered": len(block["remembered"]),
        "unit": signal_units(design).get("command", ""),
        "literals": lambda row: ", ".join(map(real, row)),
    }
    check = {
        "check.st": rendered("flash/check.st.j2", design, **values),
        "vectors.csv": table(design, found),
    }
    return {**files, "README.md": rendered("flash/plc.md.j2", design, **values), "check": check}


def folder(design: Design) -> Content:
    """The function block of a design, its page, its vectors, and a program that runs them.

    Raises:
        UserError: the kind has no such code, or a name is none of the language.
    """
    return with_vectors(design, {f"{code.c_name(design)}.st": code.block(design)})


ST = "a folder with a function block in Structured Text (IEC 61131-3), a page on it and its check"
FORMATS = (Format("st", ST, folder, beside=page_of_axes),)
