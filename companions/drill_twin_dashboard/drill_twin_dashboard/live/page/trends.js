// SPDX-License-Identifier: Apache-2.0
// The channels of the rig: present value in large digits, limits, and the trend over the last minutes (plotly).
import { $, element, state } from "./state.js";
import { say } from "./connection.js";
import { number, onUnits, size, text, unit } from "./units.js";

const CHANNELS = [  // trend, words, quantity, and a second channel drawn behind it
  ["wob", "weight on bit", "force"], ["rps", "rotation", "rotation", "bit_rps"], ["torque", "torque", "torque"],
  ["hookload", "hookload", "force"], ["rop", "rate of penetration", "rate"],
];
const SPANS = { "1 min": 60, "2 min": 120, "5 min": 300, "10 min": 600, "30 min": 1800 };
const POINTS = 240, PERIOD = 1000, LEAST = 10;  // most points of a line; ms between two drawings; s of the shortest axis
const LINE = "#56b4e9", BEHIND = "#cc79a7", LIMIT = "#ff7a6b", WINDOW = "rgba(53, 192, 142, 0.13)";
const limit = (channel, side) => state.picture?.limits?.[channel]?.[side];

export function offerTrends() {
  $("trends").append(...CHANNELS.map(([channel, words, quantity]) => {
    const entry = (side) => element("input", {
      id: `${channel}_${side}`, type: "number", step: "any", placeholder: "none", "aria-label": `${side} limit of the ${words}`,
      onchange: ({ target }) => say({ [target.id]: target.value === "" ? false : +target.value * size(quantity) }),
    });
    const value = element("p", { className: "value" }, element("output", { id: channel, textContent: "-" }), " ", element("span", { className: "unit", id: `${channel}_unit` }));
    const limits = element("p", { className: "limits" }, "limits", entry("low"), "to", entry("high"));
    const chart = element("div", { className: "chart", id: `${channel}_chart`, role: "img" });
    return element("article", { className: "channel", id: `${channel}_channel` }, element("div", {}, element("h3", { textContent: words }), value, limits), chart);
  }));
  $("span").append(...Object.entries(SPANS).map(([name, seconds]) => element("option", { value: seconds, textContent: name, selected: seconds === 300 })));
  $("span").addEventListener("change", drawTrends);
  onUnits(drawTrends);
  setInterval(drawTrends, PERIOD);
}

export function showValues(picture) {
  for (const [channel, , quantity] of CHANNELS) {
    const value = picture.rig[channel], { low, high } = picture.limits?.[channel] ?? {};
    $(channel).textContent = number(value, quantity, 1);
    $(`${channel}_unit`).textContent = unit(quantity);
    $(`${channel}_channel`).classList.toggle("beyond", value < low || value > high);
    for (const [side, own] of Object.entries({ low, high })) {
      const box = $(`${channel}_${side}`);
      if (document.activeElement !== box) box.value = own === undefined ? "" : +(own / size(quantity)).toPrecision(5);
    }
  }
}

// Rows of the present span as columns [time, least, mean, largest], several intervals in one where there are too many.
function lines(channel, quantity, begin, end) {
  const { rows, channels, seconds } = state.trends, at = 1 + 3 * channels.indexOf(channel), scale = size(quantity);
  const several = Math.max(1, Math.ceil((end - begin) / seconds / POINTS)), groups = [];
  for (const row of rows.filter(([place]) => place * seconds >= begin && place * seconds <= end)) {
    if (Math.floor(row[0] / several) === Math.floor(groups.at(-1)?.[0][0] / several)) groups.at(-1).push(row);
    else groups.push([row]);
  }
  const column = (k, of) => groups.map((group) => {
    const known = group.map((row) => row[at + k]).filter((value) => value !== null);
    return known.length ? of(known) / scale : null;
  });
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  return { time: groups.map((group) => (group[0][0] + 0.5 * group.length) * seconds),
    low: column(0, (values) => Math.min(...values)), mean: column(1, mean), high: column(2, (values) => Math.max(...values)) };
}

function traces(found, colour, opacity) {
  const line = (y, more) => ({ type: "scatter", mode: "lines", x: found.time, y, hoverinfo: "skip", ...more });
  return [line(found.low, { line: { width: 0 } }), line(found.high, { line: { width: 0 }, fill: "tonexty", fillcolor: `${colour}${opacity}` }),
    line(found.mean, { line: { width: 2, color: colour }, hoverinfo: "x+y" })];
}

function shapes(channel, quantity) {
  const map = state.picture?.map, window = map?.window.length ? { wob: map.window.slice(0, 2), rps: map.window.slice(2, 4) }[channel] : null;
  const across = { xref: "paper", x0: 0, x1: 1 };
  const edges = ["low", "high"].map((side) => limit(channel, side)).filter((value) => value !== undefined).map((value) => value / size(quantity));
  return [...edges.map((y) => ({ type: "line", ...across, y0: y, y1: y, line: { color: LIMIT, width: 2, dash: "dash" } })),
    ...(window ? [{ type: "rect", ...across, y0: window[0] / size(quantity), y1: window[1] / size(quantity), fillcolor: WINDOW, line: { width: 0 }, layer: "below" }] : [])];
}

export function drawTrends() {
  if (!window.Plotly || !state.trends.channels.length || document.hidden) return;
  const { rows, seconds } = state.trends, end = state.picture?.time ?? (rows.at(-1)?.[0] ?? 0) * seconds;
  const begin = Math.max(end - +$("span").value, Math.min(Math.max(end - LEAST, 0), (rows[0]?.[0] ?? 0) * seconds));
  CHANNELS.forEach(([channel, words, quantity, behind], place) => {
    const box = $(`${channel}_chart`), seen = box.getBoundingClientRect();
    if (seen.bottom < 0 || seen.top > innerHeight) return;  // plotly takes a tenth of a second for all of them
    const found = lines(channel, quantity, begin, end), last = place === CHANNELS.length - 1;
    const all = [...(behind ? traces(lines(behind, quantity, begin, end), BEHIND, "55") : []), ...traces(found, LINE, "55")];
    const known = all.flatMap((one) => one.y).filter((value) => value !== null), edges = shapes(channel, quantity).filter((one) => one.type === "line").map((one) => one.y0);
    const low = Math.min(...known, ...edges), high = Math.max(...known, ...edges), room = 0.08 * (high - low) || Math.max(0.1 * Math.abs(high), 1e-3);
    box.setAttribute("aria-label", known.length ? `${words} over ${$("span").selectedOptions[0].textContent}: from ${text(Math.min(...found.low) * size(quantity), quantity)} to ${text(Math.max(...found.high) * size(quantity), quantity)}` : `no ${words}`);
    Plotly.react(box, all, {
      margin: { l: 52, r: 8, t: 4, b: last ? 22 : 6 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, font: { color: "#a9afb8", size: 13, family: "system-ui, sans-serif" },
      xaxis: { range: [begin, end], gridcolor: "#3a3f48", zeroline: false, showticklabels: last, ticksuffix: " s", fixedrange: true },
      yaxis: { range: known.length ? [low - room, high + room] : [0, 1], gridcolor: "#3a3f48", zeroline: false, nticks: 5, fixedrange: true, showticklabels: known.length > 0 },
      shapes: shapes(channel, quantity), dragmode: false, hovermode: "x",
      annotations: known.length ? [] : [{ text: channel === "rop" ? "the bit does not drill" : "no values", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5, font: { size: 15 } }],
    }, { displayModeBar: false, responsive: true });
  });
}

export function trendsTable() {
  const { rows, channels, seconds } = state.trends, known = CHANNELS.flatMap(([channel, words, quantity, behind]) => [[channel, words, quantity], ...(behind ? [[behind, "bit speed", quantity]] : [])]);
  const heads = known.flatMap(([, words, quantity]) => ["least", "mean", "largest"].map((which) => `"${words}, ${which} [${unit(quantity)}]"`));
  const cells = (row) => known.flatMap(([channel, , quantity]) => [0, 1, 2].map((k) => row[1 + 3 * channels.indexOf(channel) + k]).map((value) => value === null ? "" : +(value / size(quantity)).toPrecision(6)));
  return [["time [s]", ...heads], ...rows.map((row) => [(row[0] + 0.5) * seconds, ...cells(row)])].map((row) => row.join(",")).join("\n") + "\n";
}
