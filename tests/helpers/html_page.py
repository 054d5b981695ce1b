"""What a page of HTML consists of."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """Elements, attributes, and the texts of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.texts, self.ids, self.open = [], [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.texts.append("")
        self.open = True
        self.ids += [value for key, value in attributes if key == "id"]

    def handle_endtag(self, tag):
        self.open = False

    def handle_data(self, text):
        if self.open:
            self.texts[-1] += text

    def of(self, tag):
        """Attributes and text of every element of a kind."""
        pairs = zip(self.elements, self.texts, strict=True)
        return [(own, text) for (name, own), text in pairs if name == tag]

    @property
    def addresses(self):
        """All that it shows or leads to."""
        keys = ("src", "href", "xlink:href")
        return [own[key] for _, own in self.elements for key in keys if own.get(key)]
