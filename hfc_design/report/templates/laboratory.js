"use strict";
// Bytes of a text, and doubles of what report/laboratory.py has packed.
async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(plain).arrayBuffer());
}
async function doubles(text) {
  const bytes = await unpacked(text), count = bytes.length / 8, halves = new Uint32Array(2 * count);
  const part = (k, first) => bytes[first * count + k] | bytes[(first + 1) * count + k] << 8
    | bytes[(first + 2) * count + k] << 16 | bytes[(first + 3) * count + k] << 24;
  let low = 0, high = 0, lower = 0, higher = 0;
  for (let k = 0; k < count; k += 1) {  // sums of 64 bits, twice
    lower += part(k, 0) >>> 0;
    higher = (higher + part(k, 4) + (lower > 0xffffffff)) >>> 0;
    lower >>>= 0;
    low += lower;
    high = (high + higher + (low > 0xffffffff)) >>> 0;
    low >>>= 0;
    halves.set([low, high], 2 * k);
  }
  return new Float64Array(halves.buffer);
}

// The simulator of a page, which runs in a worker: two machines at once, see formats/loop_code.py.
function simulator() {
  let data, made, memory, places, motions, machines, size;

  async function prepared(given) {
    data = { ...given };
    for (const name of ["loop", "parameters", "gains", "start", "machines"]) {
      data[name] = await doubles(given[name]);
    }
    machines = data.machines;
    size = data.parameters.length;
    motions = {};
    for (const { name, steps, columns } of data.motions) {
      const width = columns.length, rows = new Float64Array(steps * width), series = [];
      for (const [j, column] of columns.entries()) {
        if (typeof column === "string") series[j] = await doubles(column);
        const values = Array.isArray(column) ? series[column[0]] : series[j];
        for (let k = 0; k < steps; k += 1) rows[k * width + j] = values ? values[k] : column;
      }
      motions[name] = { steps, width, rows };
    }
    const longest = Math.max(...Object.values(motions).map(({ rows }) => rows.length));
    const lanes = { parameters: size, fixed: data.sizes.fixed, state: data.sizes.state,
                    values: data.sizes.values };
    const shared = { loop: data.loop.length, nominal: size, gains: data.gains.length, every: 1,
                     start: data.start.length, row: longest };
    let top = 0;
    places = {};
    for (const [name, count] of Object.entries(lanes)) { places[name] = top; top += 16 * count; }
    for (const [name, count] of Object.entries(shared)) {
      places[name] = top;
      top += 16 * Math.ceil(count / 2);
    }
    const store = new WebAssembly.Memory({ initial: 1 + Math.ceil(top / 65536) });
    const compiled = new WebAssembly.Module(await unpacked(data.module));
    const called = WebAssembly.Module.imports(compiled).map(({ name }) => [name, Math[name]]);
    const m = { ...Object.fromEntries(called), memory: store };
    made = new WebAssembly.Instance(compiled, { m }).exports;
    memory = new Float64Array(store.buffer);
    memory.set([data.every], places.every / 8);
    memory.set(data.start, places.start / 8);
  }

  // Errors and commands (machines, axes, points), metrics (machines, values).
  function simulated({ gains, factors, shifts, loop, first: from, count, motion, points }) {
    const at = places, { steps, width, rows } = motions[motion], axes = data.places.length;
    const stride = Math.max(1, Math.ceil(steps / points)), shown = Math.ceil(steps / stride);
    const error = new Float64Array(count * axes * shown), command = error.slice();
    const values = new Float64Array(count * data.metrics.length);
    memory.set(loop, at.loop / 8);
    memory.set(gains, at.gains / 8);
    memory.set(data.parameters.map((x, k) => x * factors[k] + shifts[k]), at.nominal / 8);
    memory.set(rows, at.row / 8);
    const { state, row } = at, first = state / 8;
    for (let begin = 0; begin < count; begin += 2) {
      for (let lane = 0; lane < 2; lane += 1) {
        const number = from + Math.min(begin + lane, count - 1);
        for (let k = 0; k < size; k += 1) {
          memory[at.parameters / 8 + 2 * k + lane]
            = machines[number * size + k] * factors[k] + shifts[k];
        }
      }
      made.prepare(at.loop, at.parameters, at.fixed);
      made.begin(at.loop, at.fixed, at.gains, at.start, state);
      for (let k = 0; k < steps; k += 1) {
        const drawn = k % stride === 0, given = row / 8 + width * k;
        for (let lane = 0; drawn && lane < 2 && begin + lane < count; lane += 1) {
          for (let axis = 0; axis < axes; axis += 1) {
            const to = ((begin + lane) * axes + axis) * shown + k / stride;
            error[to] = memory[given + data.references[axis]]
              - memory[first + 2 * data.places[axis] + lane];
            command[to] = memory[first + 2 * (data.commands + axis) + lane];
          }
        }
        made.sample(at.loop, at.nominal, at.fixed, at.every, at.gains, state, row + 8 * width * k);
      }
      made.judge(at.loop, state, at.values);
      for (let lane = 0; lane < 2 && begin + lane < count; lane += 1) {
        for (let k = 0; k < data.metrics.length; k += 1) {
          values[(begin + lane) * data.metrics.length + k] = memory[at.values / 8 + 2 * k + lane];
        }
      }
    }
    return { error, command, values, shown, stride, motion, count };
  }

  self.onmessage = async ({ data: { kind, given, ticket } }) => {
    if (kind === "prepare") {
      await prepared(given);
      self.postMessage({ ready: true });
      return;
    }
    const found = simulated(given);
    self.postMessage({ found, ticket }, [found.error.buffer, found.command.buffer]);
  };
}

// What the reader sees and moves.
const shownOf = (id) => document.getElementById(id);
const data = JSON.parse(shownOf("laboratory-data").textContent);
const dark = matchMedia("(prefers-color-scheme: dark)");
const own = {};
const digits = (x) => Number(x.toPrecision(4)).toString();
const STEPS = 1000, POINTS = 500, FAR = 1, KEPT_AFTER = 300;
const moved = new Map();  // number of a slider -> its value; those that are not moved are not in it
let machines = 20, motion = data.motions[0].name, axis = 0, before = null, now = null;

const valueOf = (one, place) => one.low > 0 || one.high < 0
  ? one.low * (one.high / one.low) ** (place / STEPS)
  : one.low + (one.high - one.low) * place / STEPS;
const placeOf = (one, value) => Math.round(STEPS * (one.low > 0 || one.high < 0
  ? Math.log(value / one.low) / Math.log(one.high / one.low)
  : (value - one.low) / (one.high - one.low)));

function asked(original) {
  const gains = own.gains.slice(), loop = own.loop.slice();
  const factors = own.factors.slice(), shifts = factors.map(() => 0);
  for (const [k, value] of original ? [] : moved) {
    const one = data.sliders[k];
    for (const [place, slope] of one.effects) {
      if (one.of === "gains") gains[place] += slope * (value - one.value);
      else if (one.of === "loop") loop[place] += slope * (value - one.value);
      else if (one.value) factors[place] = value / one.value;
      else shifts[place] = value;
    }
  }
  return { gains, factors, shifts, loop, motion, points: POINTS, count: original ? 1 : machines };
}

function chart(place, label, part) {
  const ink = dark.matches ? "#b0b0b0" : "#444", line = dark.matches ? "#3a3d42" : "#e2e2e2";
  const colour = dark.matches ? "#56B4E9" : "#0072B2";
  const axes = { stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 } };
  const curve = (found, machine) => {
    const begin = (machine * data.axes.length + axis) * found.shown;
    return found[part].subarray(begin, begin + found.shown);
  };
  const others = (plot) => {
    const context = plot.ctx;
    context.save();
    context.beginPath();
    context.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    context.clip();
    context.strokeStyle = colour;
    context.globalAlpha = Math.max(0.1, 0.5 / Math.sqrt(now.count));
    const across = plot.data[0].map((x) => plot.valToPos(x, "x", true));
    const zero = plot.valToPos(0, "y", true), slope = plot.valToPos(1, "y", true) - zero;
    context.beginPath();  // all in one: each alone takes twice as long
    for (let machine = 1; machine < now.count; machine += 1) {
      const values = curve(now, machine);
      context.moveTo(across[0], zero + slope * values[0]);
      for (let k = 1; k < values.length; k += 1) context.lineTo(across[k], zero + slope * values[k]);
    }
    context.stroke();
    context.restore();
  };
  // What most machines do, at most FAR times what the nominal ones do: one that diverges would
  // hide all others.
  const range = () => {
    const ends = (found, machine) => {
      let low = 0, high = 0;
      for (const y of curve(found, machine)) {
        if (y < low) low = y;
        if (y > high) high = y;
      }
      return [low, high];
    };
    const two = [ends(before, 0), ends(now, 0)].filter((one) => one.every(Number.isFinite));
    const inner = [Math.min(...two.map((one) => one[0])), Math.max(...two.map((one) => one[1]))];
    const size = inner[1] - inner[0] || 1;
    const all = Array.from({ length: now.count }, (_, machine) => ends(now, machine));
    const low = Math.max(Math.min(...all.map((one) => one[0])), inner[0] - FAR * size);
    const high = Math.min(Math.max(...all.map((one) => one[1])), inner[1] + FAR * size);
    const [least, most] = [Math.min(low, inner[0]), Math.max(high, inner[1])];
    return [least - 0.05 * (most - least), most + 0.05 * (most - least) || 1];
  };
  const plot = new uPlot({
    width: place.clientWidth, height: 220, scales: { x: { time: false }, y: { range } },
    series: [
      { label: "time [s]", value: (_, x) => (x == null ? "–" : digits(x)) },
      { label: "before", stroke: ink, dash: [6, 4], value: (_, x) => (x == null ? "–" : digits(x)) },
      { label: "now", stroke: colour, width: 2, value: (_, x) => (x == null ? "–" : digits(x)) },
    ],
    axes: [{ ...axes, label: "time [s]", labelSize: 22 }, { ...axes, label, labelSize: 22, size: 62 }],
    cursor: { sync: { key: "laboratory" }, drag: { x: true, y: false } },
    hooks: { drawAxes: [others] },
  }, [[0], [0], [0]], place);
  return () => {
    const time = Array.from({ length: now.shown }, (_, k) => k * now.stride * data.every);
    plot.setData([time, curve(before, 0), curve(now, 0)]);
  };
}

function element(name, properties, ...inside) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...inside);
  return made;
}

// A slider with its label and its value; ``changed`` is called with each new value.
function slider(label, one, value, changed) {
  const text = element("output", {}), id = `laboratory-${slider.count = (slider.count || 0) + 1}`;
  const input = element("input", { type: "range", id, min: 0, max: STEPS, step: 1 });
  const show = (x, quietly) => {
    input.value = placeOf(one, x);
    text.value = `${digits(x)} ${one.unit || ""}`;
    input.setAttribute("aria-valuetext", text.value);
    if (!quietly) changed(x);
  };
  input.oninput = () => {
    const x = valueOf(one, Number(input.value));
    text.value = `${digits(x)} ${one.unit || ""}`;
    input.setAttribute("aria-valuetext", text.value);
    changed(x);
  };
  show(value, true);
  return { show, row: element("p", {}, element("label", { htmlFor: id }, label), input, text) };
}

// Each worker simulates its share of the machines, an even number.
const program = URL.createObjectURL(
  new Blob([`${unpacked}${doubles}(${simulator})()`], { type: "text/javascript" }));
const cores = Math.max(1, Math.min(4, navigator.hardwareConcurrency || 1));
const workers = Array.from({ length: cores }, () => new Worker(program));
let pieces = [], ready = 0, ticket = 0;

// Answers to earlier questions are dropped.
function simulate(given) {
  busy = true;
  waiting = null;
  ticket += 1;
  const each = 2 * Math.ceil(given.count / (2 * workers.length)), parts = [];
  for (let first = 0; first < given.count; first += each) {
    parts.push({ ...given, first, count: Math.min(each, given.count - first) });
  }
  pieces = parts.map(() => null);
  parts.forEach((part, k) => workers[k].postMessage({ kind: "simulate", given: part, ticket }));
}

function joined() {
  const all = (name) => {
    const whole = new Float64Array(pieces.reduce((sum, one) => sum + one[name].length, 0));
    pieces.reduce((at, one) => { whole.set(one[name], at); return at + one[name].length; }, 0);
    return whole;
  };
  const count = pieces.reduce((sum, one) => sum + one.count, 0);
  return { ...pieces[0], count, error: all("error"), command: all("command"), values: all("values") };
}
let waiting = null, busy = false, redraw = [], rows = [];

// A choice with its label; ``changed`` is called with the number of the chosen one.
function choice(label, names, chosen, changed) {
  const id = `laboratory-${label}`, input = element("select", { id },
    ...names.map((name, k) => element("option", { value: k, textContent: name })));
  input.value = chosen;
  input.onchange = () => changed(Number(input.value));
  return element("p", { hidden: names.length < 2 },
    element("label", { htmlFor: id }, label), input);
}

// What was moved, as the part of the address behind "#"; and back.
// Browsers allow a hundred changes of the address in half a minute.
let keeping = 0;
function keep() {
  clearTimeout(keeping);
  keeping = setTimeout(kept, KEPT_AFTER);
}
function kept() {
  const values = Object.fromEntries([...moved].map(([k, x]) => [data.sliders[k].label, x]));
  const state = JSON.stringify({ values, machines, motion, axis });
  history.replaceState(null, "", `#${encodeURIComponent(state)}`);
}
function recall() {
  let state = {};
  try { state = JSON.parse(decodeURIComponent(location.hash.slice(1))); } catch { return; }
  for (const [k, one] of data.sliders.entries()) {
    const value = state.values?.[one.label];
    if (Number.isFinite(value)) moved.set(k, value);
  }
  if (state.machines >= 1 && state.machines <= data.most) machines = Math.round(state.machines);
  if (data.motions.some(({ name }) => name === state.motion)) motion = state.motion;
  if (data.axes[state.axis] !== undefined) axis = state.axis;
}

// The design with the moved gains, in the form of design.json.
function changedDesign() {
  const design = structuredClone(data.design);
  for (const [k, value] of moved) {
    const parts = data.sliders[k].of === "gains" ? data.sliders[k].key.split(".") : [];
    const last = parts.pop();
    if (last) parts.reduce((part, name) => part[name], design)[last] = value;
  }
  delete design.score;  // of the design before
  return design;
}
function download() {
  const text = `${JSON.stringify(changedDesign(), null, 1)}\n`;
  const address = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  element("a", { href: address, download: "design.json" }).click();
  URL.revokeObjectURL(address);
}

// Only the last of several wishes is simulated.
function ask() {
  keep();
  waiting = asked(false);
  if (!busy) simulate(waiting);
}

// Another motion has another curve before the change.
function restart() {
  before = null;
  simulate(asked(true));
}

function told(found) {
  const lines = data.metrics.map((name, k) => {
    const each = Array.from({ length: found.count }, (_, n) => found.values[n * data.metrics.length + k]);
    const sorted = each.toSorted((a, b) => a - b), old = before.values[k];
    return element("tr", {}, element("th", { scope: "row", textContent: name }),
      ...[old, each[0], sorted[0], sorted.at(-1)].map((x) => element("td", {
        className: "value", textContent: Number.isFinite(x) ? digits(x) : "–" })));
  });
  shownOf("laboratory-values").replaceChildren(...lines);
}

workers.forEach((worker, k) => {
  worker.onmessage = ({ data: answer }) => {
    ready += Boolean(answer.ready);
    if (answer.ready) { if (ready === workers.length) restart(); return; }
    if (answer.ticket !== ticket) return;
    pieces[k] = answer.found;
    if (pieces.every(Boolean)) answered(joined());
  };
  worker.onerror = (problem) => {
    shownOf("laboratory-problem").textContent
      = `The laboratory does not work here: ${problem.message}`;
  };
});

function answered(found) {
  busy = false;
  if (before === null) { before = found; ask(); return; }
  now = found;
  if (!redraw.length) {
    const { error, command } = data.units, places = shownOf("laboratory-charts");
    redraw = [["error", error], ["command", command]].map(([part, unit]) =>
      chart(places.appendChild(element("div", {})), `${part} [${unit}]`, part));
  }
  redraw.forEach((one) => one());
  told(now);
  if (waiting) simulate(waiting);
}

async function begin() {
  recall();
  own.gains = await doubles(data.gains);
  own.loop = await doubles(data.loop);
  own.factors = (await doubles(data.parameters)).fill(1);
  const groups = { gains: "Controller", parameters: "Machine", loop: "Limits and sensors" };
  const boxes = Object.entries(groups).map(([of, title]) => {
    const inside = data.sliders.map((one, k) => [one, k]).filter(([one]) => one.of === of);
    const made = inside.map(([one, k]) => {
      const change = (x) => { moved.set(k, x); ask(); };
      const { show, row } = slider(one.label, one, moved.get(k) ?? one.value, change);
      rows[k] = show;
      return row;
    });
    return element("fieldset", {}, element("legend", { textContent: title }), ...made);
  });
  const many = { low: 1, high: data.most, unit: "" }, names = data.motions.map(({ name }) => name);
  const count = slider("machines", many, machines, (x) => { machines = Math.round(x); ask(); });
  const reset = element("button", { type: "button", textContent: "Reset" });
  reset.onclick = () => {
    data.sliders.forEach((one, k) => rows[k](one.value, true));
    moved.clear();
    ask();
  };
  const save = element("button", { type: "button", textContent: "Download changed design.json" });
  save.onclick = download;
  const choices = [
    choice("motion", names, names.indexOf(motion), (k) => { motion = names[k]; restart(); }),
    choice("axis", data.axes, axis, (k) => { axis = k; ask(); }),
  ];
  shownOf("laboratory-controls").append(element("fieldset", {},
    element("legend", { textContent: "Drawn" }), ...choices, count.row, reset, " ", save), ...boxes);
  shownOf("laboratory").hidden = false;
  workers.forEach((worker) => worker.postMessage({ kind: "prepare", given: data }));
}
begin();
