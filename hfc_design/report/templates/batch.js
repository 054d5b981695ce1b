"use strict";
// Sorting and searching; without it the table is just as complete.
const body = document.querySelector(".runs tbody");
const order = [...body.rows];
const heads = [...document.querySelectorAll(".runs thead th")];
heads.forEach((head, column) => {
  const button = document.createElement("button");
  button.textContent = head.textContent;
  head.replaceChildren(button);
  button.onclick = () => {
    const down = head.getAttribute("aria-sort") === "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const keyed = order.map((row, place) => {
      const text = row.cells[column].textContent;
      return { row, place, text, number: text.trim() === "" ? NaN : Number(text) };
    });
    keyed.sort((a, b) => {
      const words = isNaN(a.number) - isNaN(b.number);  // what is no number stands last
      const found = isNaN(a.number) && isNaN(b.number)
        ? (a.text < b.text ? -1 : a.text > b.text ? 1 : 0) : a.number - b.number;
      return words || (down ? -found : found) || a.place - b.place;
    });
    body.append(...keyed.map((item) => item.row));
  };
});
const search = document.createElement("input");
search.type = "search";
search.placeholder = "only runs with …";
search.setAttribute("aria-label", "only runs with these words");
search.oninput = () => {
  const words = search.value.toLowerCase().split(/\s+/);
  for (const row of order) {
    const text = row.textContent.toLowerCase();
    row.hidden = !words.every((word) => text.includes(word));
  }
};
document.querySelector(".controls").append(search);
