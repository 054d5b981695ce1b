"""The report of a run: one page that needs nothing else, not even a network; its pictures."""

from jinja2 import Environment, PackageLoader, StrictUndefined

from hfc_design.pictures.figure import address

REPORT = "report.html"


def rendered(name: str, /, **values: object) -> bytes:
    """The page of a template; everything that stands in the values is escaped."""
    environment = Environment(
        loader=PackageLoader("hfc_design.report"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["picture"] = address
    return environment.get_template(name).render(**values).encode()
