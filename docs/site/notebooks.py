"""Pages of the notebooks, as they are stored: text, code, and what came out."""

import base64
import json
from pathlib import Path
from typing import Any

#: Kinds of pictures that a cell puts out -> suffix of their files.
KINDS = {"image/svg+xml": "svg", "image/png": "png"}


def page(path: Path, folder: Path) -> str:
    """The page of a notebook in Markdown; its pictures are written to ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    cells, pictures = json.loads(path.read_text("utf-8"))["cells"], 0
    parts = []
    for cell in cells:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(text)
            continue
        parts.append(f"```python\n{text}\n```")
        printed = "".join("".join(one.get("text", ())) for one in cell["outputs"])
        if printed:
            parts.append(f"```text\n{printed.rstrip()}\n```")
        for output in cell["outputs"]:
            shown = output.get("data", {})
            kind = next((one for one in KINDS if one in shown), None)
            if kind is not None:
                pictures += 1
                file = folder / f"{path.stem}-{pictures}.{KINDS[kind]}"
                file.write_bytes(_picture(shown[kind], kind))
                parts.append(f'<p><img src="{file.name}" alt="What the cell above draws"></p>')
            elif shown:
                parts.append(_table_or_text(shown))
    return "\n\n".join(parts) + "\n"


def _picture(data: str | list[str], kind: str) -> bytes:
    text = "".join(data)
    return base64.b64decode(text) if kind == "image/png" else text.encode()


def _table_or_text(shown: dict[str, Any]) -> str:
    if "text/html" in shown:
        return "".join(shown["text/html"])
    return "```text\n" + "".join(shown["text/plain"]) + "\n```"
