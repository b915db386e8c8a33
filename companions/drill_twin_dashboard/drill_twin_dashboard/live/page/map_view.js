// SPDX-License-Identifier: Apache-2.0
// Operating map with the present set-point and the advised one (plotly).
import { $, element, replace, state } from "./state.js";
import { onUnits, size, unit } from "./units.js";

let drawn = "";

function legend(map) {
  const entry = (name, colour) => element("span", {}, ...(colour ? [element("i", { style: `background: ${colour}` })] : []), name);
  replace($("map_legend"), [map.codes, map.regimes], () => [
    ...map.regimes.flatMap((name, k) => map.codes.includes(k.toString(16)) ? [entry(name, map.colours[k])] : []), entry("solid: whirl begins from rest"),
    ...(map.keeps !== map.whirls ? [entry("dashed: an existing whirl dies or creeps")] : []), ...(map.window.length ? [entry("white: largest calm window")] : []),
  ]);
}

export function drawMap() {
  const { map, rig, advice } = state.picture ?? {};
  if (!map || !window.Plotly || $("advice").hidden) return;
  legend(map);
  const force = size("force"), rotation = size("rotation"), clamp = (value, [low, high]) => typeof value === "number" ? Math.min(Math.max(value, low), high) : value;
  const here = [clamp(rig.rps, map.rps), clamp(rig.wob, map.wob)], there = [advice.rps, advice.wob];
  const key = JSON.stringify([map.digest, map.codes.length, here.map((value) => value?.toPrecision(3)), there, unit("force"), unit("rotation")]);
  if (key === drawn) return;
  drawn = key;
  const side = Math.round(Math.sqrt(map.codes.length)), along = ([low, high], scale) => Array.from({ length: side }, (_, k) => (low + (high - low) * k / (side - 1)) / scale);
  const grid = (digits) => Array.from({ length: side }, (_, i) => Array.from(digits.slice(i * side, (i + 1) * side), (digit) => parseInt(digit, 16)));
  const x = along(map.rps, rotation), y = along(map.wob, force), codes = grid(map.codes);
  const edge = (digits, dash) => ({ type: "contour", x, y, z: grid(digits), showscale: false, hoverinfo: "skip", autocontour: false, contours: { start: 0.5, end: 0.5, size: 1, coloring: "none" }, line: { color: "#000", width: 2.5, dash } });
  const spot = ([rps, wob], marker) => ({ type: "scatter", mode: "markers", x: [rps / rotation], y: [wob / force], marker, hoverinfo: "x+y", cliponaxis: false });
  const known = (at) => at.every((value) => typeof value === "number");
  const axis = (range, scale, title) => ({ range: range.map((value) => value / scale), title: { text: title, standoff: 6 }, zeroline: false, fixedrange: true, automargin: true });
  const line = known(here) && known(there) ? [{ type: "scatter", mode: "lines", x: [here[0] / rotation, there[0] / rotation], y: [here[1] / force, there[1] / force], line: { color: "#fff", width: 3 }, hoverinfo: "skip" }] : [];
  Plotly.react($("map"), [
    { type: "heatmap", x, y, z: codes, zmin: -0.5, zmax: map.colours.length - 0.5, colorscale: map.colours.flatMap((colour, k) => [[k / map.colours.length, colour], [(k + 1) / map.colours.length, colour]]), showscale: false, opacity: 0.85, customdata: codes.map((row) => row.map((code) => map.regimes[code] ?? "unknown")), hovertemplate: "%{customdata}<extra></extra>" },
    edge(map.whirls, "solid"), ...(map.keeps !== map.whirls ? [edge(map.keeps, "dash")] : []), ...line,
    ...(known(there) ? [spot(there, { size: 12, color: "#fff", symbol: "circle-open", line: { width: 3 } })] : []),
    ...(known(here) ? [spot(here, { size: 13, color: "#000", line: { color: "#fff", width: 3 } })] : []),
  ], {
    margin: { l: 48, r: 12, t: 6, b: 36 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, dragmode: false, font: { color: "#a9afb8", size: 12, family: "system-ui, sans-serif" },
    xaxis: axis(map.rps, rotation, `speed [${unit("rotation")}]`), yaxis: axis(map.wob, force, `weight on bit [${unit("force")}]`),
    shapes: map.window.length ? [{ type: "rect", x0: map.window[2] / rotation, x1: map.window[3] / rotation, y0: map.window[0] / force, y1: map.window[1] / force, line: { color: "#fff", width: 2 } }] : [],
  }, { displayModeBar: false, responsive: true });
}

onUnits(drawMap);
