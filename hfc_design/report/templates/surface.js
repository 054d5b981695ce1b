"use strict";
// A cursor on each surface tells which rules fire there. Without it the pictures are complete.
const LEAST = 0.01;  // share of a rule that is listed
const LARGER = 10;  // steps of an arrow key with Shift
const HOW = "Click or use the arrow keys (with Shift in larger steps) to move the cursor. " +
  "Circles are the rules that fire, at the peaks of their terms; their size is the share of the rule.";

function degree(term, u) {
  if ("sigma" in term) {
    const away = Math.max(term.low - u, u - term.high, 0) / term.sigma;
    return Math.exp(-0.5 * away * away);
  }
  const up = term.left === null ? 1 : (u - term.left) / (term.centre - term.left);
  const down = term.right === null ? 1 : (term.right - u) / (term.right - term.centre);
  return Math.max(0, Math.min(1, up, down));
}

const degrees = (side, value) => side.terms.map((term) => degree(term, side.enters * value));

// The rules that fire, the strongest first, and what they say together, as `hfc explain` has it.
function fired(unit, column, row) {
  const inColumn = degrees(unit.column, column), rules = [];
  degrees(unit.row, row).forEach((a, i) => inColumn.forEach((b, j) => {
    if (a * b > 0) rules.push({ i, j, strength: a * b, consequent: unit.table[i][j] });
  }));
  const total = rules.reduce((sum, rule) => sum + rule.strength, 0);
  for (const rule of rules) rule.share = rule.strength / total;
  rules.sort((a, b) => b.strength - a.strength);
  const output = rules.reduce((sum, rule) => sum + rule.share * rule.consequent, 0);
  return { rules, output };
}

const digits = (value) => String(Number(value.toPrecision(6))).replace("-", "\u2212");
const percent = (share) => `${(100 * share).toFixed(2)} %`;
const within = (value, [low, high]) => Math.min(Math.max(value, low), high);

// A step that is easy to read, a hundredth of the side or up to ten times finer.
const stepOf = ([low, high]) => 10 ** Math.floor(Math.log10((high - low) / 100));
const rounded = (side, value) => {
  const step = stepOf(side.ends);
  return within(Number((Math.round(value / step) * step).toPrecision(12)), side.ends);
};

const valueAt = (side, part) =>
  rounded(side, side.ends[0] + part * (side.ends[1] - side.ends[0]));

// An element with these properties; names of users become text, never markup.
function made(name, properties = {}, ...inside) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...inside);
  return element;
}

const middle = (term) => ("sigma" in term ? (term.low + term.high) / 2 : term.centre);
const share = (side, value) => (value - side.ends[0]) / (side.ends[1] - side.ends[0]);

// A rule stands where its terms are highest, as large as its share.
function peak(unit, rule) {
  const spot = made("i", { className: "peak" }), size = `${6 + 26 * Math.sqrt(rule.share)}px`;
  const [x, y] = [[unit.column, rule.j], [unit.row, rule.i]].map(([side, k]) =>
    within(share(side, middle(side.terms[k]) / side.enters), [0, 1]));
  Object.assign(spot.style, {
    left: `${100 * x}%`, top: `${100 * (1 - y)}%`, width: size, height: size });
  return spot;
}

function lines(x, y) {
  const across = made("i", { className: "across" }), up = made("i", { className: "up" });
  across.style.top = `${100 * y}%`;
  up.style.left = `${100 * x}%`;
  return [across, up];
}

function told(unit, { rules, output }) {
  const [name, rest] = unit.said.split(" [");
  let text = `${name} = ${digits(output)}${rest === "1]" ? "" : ` ${rest.slice(0, -1)}`}`;
  if (unit.worth) {
    const [factor, of] = unit.worth;
    text += `, \u00d7 ${digits(factor)} = ${digits(factor * output)} ${of}`;
  }
  return `${text}; ${rules.length} rule${rules.length === 1 ? " fires" : "s fire"}`;
}

const cells = (first, second, ...values) => made("tr", {},
  made("th", { scope: "row", textContent: first }), made("td", { textContent: second }),
  ...values.map((text) => made("td", { className: "value", textContent: text })));

function listed(unit, { i, j, share, consequent }) {
  const label = unit.labels ? `${unit.labels[i][j]} ` : "";
  return cells(unit.row.terms[i].label, unit.column.terms[j].label, percent(share),
    label + digits(consequent));
}

function others(hidden) {
  if (!hidden.length) return [];
  const sum = hidden.reduce((sum, rule) => sum + rule.share, 0);
  return [cells(`${hidden.length} more below ${100 * LEAST} %`, "", percent(sum), "")];
}

// The surface to move on.
function placed(unit, number) {
  const place = made("div", { className: "place", tabIndex: 0 });
  const [left, top, width, height] = unit.box.map((part) => `${100 * part}%`);
  Object.assign(place.style, { left, top, width, height });
  place.setAttribute("role", "application");
  place.setAttribute("aria-label", "Cursor on the surface; arrow keys move it");
  place.setAttribute("aria-describedby", `says-${number}`);
  return place;
}

// The table of the rules that fire, and what holds it.
function ruled(unit) {
  const heads = [`if ${unit.row.name}`, `and ${unit.column.name}`, "share", "consequent"];
  const head = made("tr", {}, ...heads.map((text, k) =>
    made("th", { scope: "col", textContent: text, className: k > 1 ? "value" : "" })));
  const body = made("tbody"), table = made("table", {}, made("thead", {}, head), body);
  const rules = made("div", { className: "scroll rules", tabIndex: 0 }, table);
  rules.setAttribute("role", "region");
  rules.setAttribute("aria-label", "Rules that fire");
  return [body, rules];
}

// What stands on a surface and below it.
function built(unit, data, number) {
  const surface = data.previousElementSibling, place = placed(unit, number);
  const says = made("p", { className: "says", id: `says-${number}` }), boxes = {};
  says.setAttribute("aria-live", "polite");
  const labels = ["row", "column"].map((key) => {
    const { name, unit: of, ends: [min, max] } = unit[key];
    boxes[key] = made("input", { type: "number", step: "any", min, max });
    return made("label", {}, `${name} [${of}] `, boxes[key]);
  });
  const [body, rules] = ruled(unit);
  surface.id = `surface-${number}`;
  surface.append(place);
  data.after(made("div", { className: "fires" }, made("p", {}, ...labels), says, rules));
  if (number === 1) surface.after(made("p", { className: "how", textContent: HOW }));
  return { figure: surface.parentElement, place, says, body, boxes };
}

// What there is to see with the cursor there; the box that is being typed in stays as it is.
function show(unit, at, parts, typed) {
  for (const [key, box] of Object.entries(parts.boxes)) {
    if (box !== typed) box.value = at[key];
    box.removeAttribute("aria-invalid");
  }
  const found = fired(unit, at.column, at.row);
  const shown = found.rules.filter((rule) => rule.share >= LEAST);
  parts.place.replaceChildren(...shown.map((rule) => peak(unit, rule)),
    ...lines(share(unit.column, at.column), 1 - share(unit.row, at.row)));
  parts.says.textContent = told(unit, found);
  parts.body.replaceChildren(...shown.map((rule) => listed(unit, rule)),
    ...others(found.rules.slice(shown.length)));
}

// What is typed is no number: nothing fires that could be told.
function refuse(side, box, { place, says, body }) {
  box.setAttribute("aria-invalid", "true");
  place.replaceChildren();
  body.replaceChildren();
  const [low, high] = side.ends.map(digits);
  says.textContent = `${side.name}: a number from ${low} to ${high} is needed`;
}

function pointing(unit, place, move) {
  const pointed = (event) => {
    const box = place.getBoundingClientRect();
    move({ column: valueAt(unit.column, (event.clientX - box.left) / box.width),
      row: valueAt(unit.row, (box.bottom - event.clientY) / box.height) });
  };
  place.onpointerdown = (event) => {
    if (event.pointerType === "mouse") place.setPointerCapture(event.pointerId);
    pointed(event);
  };
  place.onpointermove = (event) => { if (event.buttons) pointed(event); };
}

const KEYS = { ArrowLeft: ["column", -1], ArrowRight: ["column", 1],
  ArrowDown: ["row", -1], ArrowUp: ["row", 1] };

function explore(data, index) {
  const unit = JSON.parse(data.textContent), parts = built(unit, data, index + 1);
  const at = { column: valueAt(unit.column, 0.6), row: valueAt(unit.row, 0.7) };
  const move = (values, typed = null) => {
    parts.figure.classList.add("moved");
    show(unit, Object.assign(at, values), parts, typed);
  };
  for (const [key, box] of Object.entries(parts.boxes)) {
    const typed = () => Number.isFinite(box.valueAsNumber);
    box.oninput = () => {
      if (typed()) move({ [key]: within(box.valueAsNumber, unit[key].ends) }, box);
      else refuse(unit[key], box, parts);
    };
    box.onchange = () => { if (typed()) move({}); };
  }
  parts.place.onkeydown = (event) => {
    if (!(event.key in KEYS) || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const [key, sign] = KEYS[event.key], step = stepOf(unit[key].ends);
    move({ [key]: rounded(unit[key], at[key] + sign * step * (event.shiftKey ? LARGER : 1)) });
  };
  pointing(unit, parts.place, move);
  show(unit, at, parts, null);
  return { unit, ...parts };
}

const surfaces = [...document.querySelectorAll("script.rules")].map(explore);
if (surfaces.length) {
  const text = surfaces.length === 1 ? "Surface with a cursor"
    : `${surfaces.length} surfaces, each with a cursor`;
  const link = made("a", { href: "#surface-1", textContent: text });
  document.querySelector("h1").after(made("p", { className: "how" }, link));
}
