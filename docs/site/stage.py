"""Lays the pages together that ``make docs`` builds its site from: ``stage.py FOLDER``.

Pages stay where they are and link to each other by relative paths, as a code host shows them. Here
they get the same places below one folder; what they link to of the sources becomes a page too.
"""

import re
import shutil
import sys
from pathlib import Path

import command_line
import notebooks
import tables

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "site"
PAGES = ("*.md", "docs/*.md", "docs/notebooks/*.md", "experiments/**/*.md", "benchmarks/*.md")
NOTEBOOKS = "docs/notebooks/*.ipynb"
PICTURES = (".png", ".svg", ".webp")
#: A fenced block, or the target of a link or picture outside of one.
PART = re.compile(r"^```.*?^```|\]\(([^)\s]+)\)", re.MULTILINE | re.DOTALL)


def linked(text: str) -> list[str]:
    """Targets of the links and pictures of a page in this tree, without anchors."""
    targets = [hit[1] for hit in PART.finditer(text) if hit[1]]
    return [file for one in targets if "//" not in one and (file := one.partition("#")[0])]


def source_page(path: Path) -> str:
    """A page that shows a file, or what a folder holds."""
    name = path.relative_to(ROOT).as_posix()
    if path.is_dir():
        files = sorted(one for one in path.iterdir() if one.is_file())
        shown = [
            f"- [{one.name}]({one.name}.md)" if one.suffix in (".py", ".toml") else f"- {one.name}"
            for one in files
        ]
        return f"# {name}\n\n" + "\n".join(shown) + "\n"
    return f"# {name}\n\n````{path.suffix[1:]}\n{path.read_text('utf-8')}````\n"


def put(folder: Path, path: Path) -> str:
    """Write the page of a source file or folder and of what is in it; its name beside ``path``."""
    place = folder / path.relative_to(ROOT)
    target = place / "index.md" if path.is_dir() else place.with_name(place.name + ".md")
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(source_page(path), encoding="utf-8")
        for one in [*path.glob("*.py"), *path.glob("*.toml")]:
            put(folder, one)
    return "/index.md" if path.is_dir() else ".md"


def stage(folder: Path) -> None:
    """Fill an empty folder with all pages.

    Raises:
        FileNotFoundError: a page links to a file that is not there.
    """
    pages = sorted(one for pattern in PAGES for one in ROOT.glob(pattern))
    books = sorted(ROOT.glob(NOTEBOOKS))
    for page in [*pages, *books]:
        place = folder / page.relative_to(ROOT).with_suffix(".md")
        text = notebooks.page(page, place.parent) if page in books else page.read_text("utf-8")
        for target in dict.fromkeys(linked(text)):
            path = (page.parent / target).resolve(strict=True)
            if path.suffix in PICTURES:
                copy = folder / path.relative_to(ROOT)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, copy)
            elif path in books:
                text = text.replace(f"]({target})", f"]({target.removesuffix('ipynb')}md)")
            elif path.suffix != ".md":
                text = text.replace(f"]({target})", f"]({target}{put(folder, path)})")
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
    reference = folder / "docs" / "reference"
    shutil.copytree(SITE / "reference", reference)
    (reference / "command-line.md").write_text(command_line.page(pages), encoding="utf-8")
    for name, text in tables.pages().items():
        (reference / f"{name}.md").write_text(text, encoding="utf-8")
    shutil.copytree(SITE / "iframe-worker", folder / "site" / "iframe-worker")
    shutil.copyfile(SITE / "style.css", folder / "site" / "style.css")


if __name__ == "__main__":
    build = Path(sys.argv[1])
    shutil.rmtree(build, ignore_errors=True)
    build.mkdir(parents=True)
    stage(build)
