"use strict";
// Curves that can be zoomed in place of the pictures for print. Without it the page is complete.
const dark = matchMedia("(prefers-color-scheme: dark)");
// Okabe and Ito's colours as in the pictures; on black those of them that are bright enough.
const palettes = {
  light: ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"],
  dark: ["#56B4E9", "#F08A3C", "#2CC79B", "#E39BC6", "#F0E442", "#7FA8FF", "#FFFFFF"],
};
const floats = (text) => {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return Array.from(new Float32Array(bytes.buffer), (x) => (Number.isNaN(x) ? null : x));
};
const digits = (value) => (value === null || value === undefined ? "–" : value.toPrecision(4));

function panel(place, data, k, last, key, width) {
  const ink = dark.matches ? "#b0b0b0" : "#444", line = dark.matches ? "#3a3d42" : "#e2e2e2";
  const colours = palettes[dark.matches ? "dark" : "light"];
  const own = data.panels[k];
  const told = { width: 1.25, points: { show: false }, value: (_, value) => digits(value) };
  const curves = own.curves.map(floats);
  const series = own.names.map((label, number) => ({
    ...told, label, stroke: colours[number % colours.length],
    dash: [undefined, [8, 4], [2, 3]][Math.floor(number / colours.length) % 3],
  }));
  if (own.reference !== null) {
    curves.push(floats(own.reference));
    series.push({ ...told, label: "reference", stroke: ink, dash: [6, 4] });
  }
  const time = curves[0].map((_, place) => place * data.step);
  const axis = { stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 } };
  return new uPlot({
    width,
    height: (k ? 140 : 220) + (last ? 50 : 0),
    scales: { x: { time: false } },
    series: [{ label: "time [s]", value: (_, value) => digits(value) }, ...series],
    axes: [
      { ...axis, ...(last ? { label: "time [s]", labelSize: 22 } : { size: 8, values: () => [] }) },
      { ...axis, label: own.label, labelSize: 22, size: 62 },
    ],
    cursor: { sync: { key, setSeries: true }, drag: { x: true, y: false }, focus: { prox: 24 } },
    focus: { alpha: 0.35 },
  }, [time, ...curves], place);
}

function draw(place, data, key) {
  const width = place.clientWidth;
  place.replaceChildren();
  const whole = document.createElement("button");
  whole.type = "button";
  whole.textContent = "whole motion";
  place.append(whole);
  const last = data.panels.length - 1;
  const drawn = data.panels.map((_, k) => panel(place, data, k, k === last, key, width));
  const end = drawn[0].data[0].at(-1);
  whole.onclick = () => drawn.forEach((one) => one.setScale("x", { min: 0, max: end }));
  return drawn;
}

const motions = JSON.parse(document.getElementById("motions").textContent);
const all = motions.map((data, number) => {
  const place = document.getElementById(`traces-${number + 1}`);
  place.hidden = false;
  const drawn = { charts: draw(place, data, `motion-${number}`) };
  place.parentElement.classList.add("live");
  dark.addEventListener("change", () => {
    drawn.charts.forEach((one) => one.destroy());
    drawn.charts = draw(place, data, `motion-${number}`);
  });
  return { place, drawn };
});
addEventListener("resize", () => all.forEach(({ place, drawn }) => {
  const width = place.clientWidth;
  if (width) drawn.charts.forEach((one) => one.setSize({ width, height: one.height }));
}));
