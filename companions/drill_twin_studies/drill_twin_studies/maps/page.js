// SPDX-License-Identifier: Apache-2.0
// Operating map: a quantity of the runs over speed and weight on bit, the run that was clicked on, its last orbit (plotly).
"use strict";

const $ = (id) => document.getElementById(id), D = JSON.parse($("map-data").textContent), N = D.steps, side = N + 1;
const GRADES = Object.keys(D.grades), grade = (run) => GRADES[run.severity ?? GRADES.length - 1];
const W = D.weight_on_bit_N, S = D.rotation_rad_s, load = (i) => W[0] + (W[1] - W[0]) * i / N, speed = (j) => S[0] + (S[1] - S[0]) * j / N;
const flagged = (flags, i, j) => flags[i * side + j] === "1", regime = (i, j) => parseInt(D.codes[i * side + j], 16);

const form = (x) => x === undefined || !Number.isFinite(x) ? "-" : Math.abs(x) >= 1e4 ? x.toExponential(2) : String(+x.toPrecision(4));
const shown = (x, of) => x / D.units[of][0], said = (x, of) => `${form(shown(x, of))} ${D.units[of][1]}`;
const setPoint = (w, s) => `${said(w, "force")}, ${said(s, "rotation")}`;
const span = ([low, high], of) => `${form(shown(low, of))} to ${said(high, of)}`;
const inside = (w, s) => w >= W[0] && w <= W[1] && s >= S[0] && s <= S[1];

const nearest = new Int32Array(side * side), shares = {};
const rest = D.runs.map((run, k) => [run, k]).filter(([run]) => !run.origin && run.finer === 1 && run.draw === 0);
for (let i = 0; i <= N; i++) for (let j = 0; j <= N; j++) {
  const far = ([run]) => (run.node[0] - i) ** 2 + (run.node[1] - j) ** 2;
  if (rest.length) nearest[i * side + j] = rest.reduce((best, one) => far(one) < far(best) ? one : best)[1];
}
const near = (i, j) => D.runs[nearest[i * side + j]];
for (const run of D.runs) if (!run.origin && run.finer === 1 && run.regime !== D.failed) (shares[run.node] ??= []).push(D.whirling.includes(run.regime) ? 1 : 0);
const share = (run) => (shares[run.node] ?? []).reduce((a, b) => a + b, 0) / (shares[run.node] ?? []).length;
const QUANTITY = { bending_stress: "stress", wall_force: "force", torque_swing: "torque" };
const value = (run, name) => name === "whirl_fraction" ? share(run) : QUANTITY[name] ? shown(run[name], QUANTITY[name]) : run[name];

// --- the map -----------------------------------------------------------------------------------------------------------

const CODED = {
  regime: [D.regimes, D.colours, regime],
  severity: [GRADES, Object.values(D.grades), (i, j) => GRADES.indexOf(grade(near(i, j)))],
};
const DASHES = { solid: "solid", dashed: "dash", dotted: "dot" };
let picked = null;

// Trace over the map through points [weight, speed], with null for a gap.
function over(name, points, look) {
  const along = (which, of) => points.map((point) => point && shown(point[which], of));
  return { type: "scatter", mode: "lines", name, x: along(1, "rotation"), y: along(0, "force"), hoverinfo: "skip", showlegend: name !== "", cliponaxis: false, ...look };
}

// Heat map of a quantity, and traces for the legend of its names.
function fields(name) {
  const steps = [...Array(side).keys()], heat = { type: "heatmap", x: steps.map((j) => shown(speed(j), "rotation")), y: steps.map((i) => shown(load(i), "force")), hoverinfo: "none" };
  const grid = (of) => steps.map((i) => steps.map((j) => of(i, j)));
  if (CODED[name]) {
    const [names, colours, of] = CODED[name], z = grid(of), n = colours.length, scale = colours.flatMap((colour, k) => [[k / n, colour], [(k + 1) / n, colour]]);
    const there = [...new Set(z.flat())].sort((a, b) => a - b);
    const entries = there.map((code) => over(names[code], [null], { mode: "markers", marker: { symbol: "square", size: 12, color: colours[code] } }));
    return [{ ...heat, z, zmin: -0.5, zmax: n - 0.5, colorscale: scale, showscale: false }, ...entries];
  }
  const values = rest.map(([run]) => value(run, name)).filter(Number.isFinite).sort((a, b) => a - b);
  const top = name === "whirl_fraction" ? 1 : values[Math.floor(0.98 * (values.length - 1))] || 1;
  const scale = ["#f7f7f7", "#fdd49e", "#ef6548", "#7f0000"].map((colour, k) => [k / 3, colour]);
  return [{ ...heat, z: grid((i, j) => value(near(i, j), name)), zmin: 0, zmax: top, colorscale: scale, colorbar: { thickness: 12 } }];
}

function draw() {
  const cells = [...D.known].flatMap((known, k) => known === "0" ? [[Math.floor(k / N), k % N]] : []);
  const unknown = cells.flatMap(([i, j]) => [[load(i), speed(j)], [load(i + 1), speed(j + 1)], null]);
  const windows = D.safe_windows.flatMap(({ weight_on_bit_N: [w0, w1], rotation_rad_s: [s0, s1] }) => [[w0, s0], [w1, s0], [w1, s1], [w0, s1], [w0, s0], null]);
  const places = (failed) => rest.filter(([run]) => (run.regime === D.failed) === failed).map(([run]) => [load(run.node[0]), speed(run.node[1])]);
  const spot = (colour) => ({ symbol: "circle-open", size: 12, color: colour, line: { width: 3 } });
  const axis = (title, of, range) => ({ title: { text: `${title} [${D.units[of][1]}]`, standoff: 6 }, range: range.map((x) => shown(x, of)), zeroline: false, automargin: true });
  Plotly.react($("map"), [
    ...fields($("field").value),
    over("not known: nearest run", unknown, { line: { color: "#222", width: 1 } }),
    ...D.boundaries.map((one) => over(one.label, one.segments.flatMap((ends) => [...ends, null]), { line: { color: one.colour, width: 1.15 * one.width, dash: DASHES[one.style] } })),
    over("", windows, { line: { color: "#fff", width: 5 } }), over("calm windows", windows, { line: { color: D.window_colour, width: 2.5 } }),
    over(D.failed, places(true), { mode: "markers", marker: { symbol: "x", size: 8, color: "#fff", line: { color: "#222", width: 1 } } }),
    over("runs", places(false), { mode: "markers", marker: { size: 4, color: "#0008" }, visible: "legendonly" }),
    over("set-point of the scene", inside(...D.own) ? [D.own] : [], { mode: "markers", marker: spot("#000") }),
    over("chosen run", picked === null ? [] : [[load(D.runs[picked].node[0]), speed(D.runs[picked].node[1])]], { mode: "markers", marker: spot("#0072b2") }),
  ].filter((one) => one.x.length), {
    margin: { l: 50, r: 10, t: 10, b: 40 }, hovermode: "closest", legend: { orientation: "h", y: -0.12, yanchor: "top" }, font: { family: "system-ui, sans-serif", size: 12 },
    xaxis: axis("speed", "rotation", S), yaxis: axis("weight on bit", "force", W), uirevision: 1,
    dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
  }, { displayModeBar: false, responsive: true });
}

// --- a place and a run ---------------------------------------------------------------------------------------------------

// The margins of the nearest node, as drill_twin computes them; the margins of the scene's own set-point are exact.
function margin(w, s) {
  const i = Math.round((w - W[0]) / (W[1] - W[0]) * N), j = Math.round((s - S[0]) / (S[1] - S[0]) * N);
  const own = w === D.own[0] && s === D.own[1], [alongW, alongS, all] = D.margins.map((field) => (field[i * side + j] ?? Infinity) / N);
  const [mw, ms, share] = own ? D.own_margin.map((x) => Math.abs(x ?? Infinity)) : [alongW * (W[1] - W[0]), alongS * (S[1] - S[0]), all];
  return { calm: flagged(D.calm, i, j), w: mw, s: ms, share, i, j };
}
function rows(id, list) {
  $(id).replaceChildren(...list.map((texts) => { const tr = document.createElement("tr"); for (const text of texts) tr.insertCell().textContent = text; return tr; }));
}
function place(w, s) {
  const m = margin(w, s), far = [[m.w, "force"], [m.s, "rotation"]].filter(([x]) => Number.isFinite(x)).map(([x, of]) => said(x, of)).join(" or ");
  const keeps = flagged(D.keeps, m.i, m.j), searched = keeps || D.runs.some((run) => run.origin);
  return [
    ["set-point", setPoint(w, s)], ["regime from rest", D.regimes[regime(m.i, m.j)]],
    ["an existing whirl", keeps ? "goes on" : searched ? "dies or creeps" : "not searched"],
    [m.calm ? "margin to the end of calm" : "to calm operation", far || "none in the ranges"],
    ["shortest way", Number.isFinite(m.share) ? `${form(100 * m.share)} % of the ranges` : "-"],
  ];
}
function numbers(run) {
  return [
    ["regime", run.regime + (run.unsettled ? `, not settled: ${run.unsettled}` : "")],
    ["severity", grade(run) + (run.decided_by ? ` by ${run.decided_by.replaceAll("_", " ")}` : "")],
    ["lateral acceleration, rms and peak", `${form(run.lateral_rms_g)}, ${form(run.lateral_peak_g)} g`],
    ["onset of whirl", run.onset_s === undefined ? "none" : `${form(run.onset_s)} s`],
    ["whirl", run.whirl_hz === undefined ? "-" : `${form(run.whirl_hz)} Hz, ratio ${form(run.ratio)}`], ["bit", run.bit ?? "-"],
    ["stick-slip index, bit and top", `${form(run.bit_index)}, ${form(run.top_index)}`],
    ["lateral motion grows at", run.growth === undefined ? "-" : `${form(run.growth)} 1/s`],
    ["largest radius", `${form(run.radius * 100)} % of the clearance`], ["wall force", said(run.wall_force, "force")],
    ["torque swing", said(run.torque_swing, "torque")], ["bending stress", said(run.bending_stress, "stress")],
    ["share of draws that whirl", shares[run.node]?.length > 1 ? `${form(share(run))} of ${shares[run.node].length}` : "one draw"],
    ...(run.failure ? [["reason", run.failure]] : []),
  ];
}
// Last orbit of a run, in thousandths of the clearance.
function orbit(run) {
  const axis = { range: [-1200, 1200], showticklabels: false, zeroline: true }, path = run.orbit ?? [];
  Plotly.react($("orbit"), [{ type: "scatter", mode: "lines", x: path.map(([x]) => x), y: path.map(([, y]) => y), line: { color: "#0072b2", width: 1.3 } }], {
    xaxis: axis, yaxis: { ...axis, scaleanchor: "x" }, margin: { l: 0, r: 0, t: 0, b: 0 },
    shapes: [{ type: "circle", x0: -1000, x1: 1000, y0: -1000, y1: 1000, line: { color: "#999", width: 1 } }],
  }, { staticPlot: true, responsive: true });
}
function pick(k) {
  picked = k;
  const run = D.runs[k];
  $("which").textContent = `at ${setPoint(load(run.node[0]), speed(run.node[1]))}`;
  $("command").textContent = D.commands[k];
  rows("run", numbers(run));
  orbit(run);
  draw();
}

for (const option of $("field").options) if (QUANTITY[option.value]) option.textContent += ` [${D.units[QUANTITY[option.value]][1]}]`;
$("name").textContent = `${D.scene_name}: operating map`;
$("about").textContent = `${D.runs.filter((run) => run.finer === 1).length} runs of ${form(D.duration_s)} s, calm set-points asked for ${form(D.calm_for_s)} s, drill_twin ${D.version}. Motion at the end of each run from rest; not validated against a rig.`;
const words = D.safe_windows.map((one) => `${span(one.weight_on_bit_N, "force")} at ${span(one.rotation_rad_s, "rotation")}`);
const lines = words.length ? [words.join("; or "), ...D.windows_rest_on.map((text) => `rests on: ${text}`)] : ["None that this map can stand behind."];
for (const [id, texts] of [["window", lines], ["notes", D.notes]]) $(id).replaceChildren(...texts.map((text, k) => Object.assign(document.createElement("p"), { textContent: text, className: id === "notes" || k ? "lead" : "" })));
rows("here", [["move over the map; a click chooses a run, a drag zooms, a double click shows all", ""]]);
rows("own", inside(...D.own) ? place(...D.own) : [["outside the ranges", setPoint(...D.own)]]);
$("copy").onclick = () => navigator.clipboard?.writeText($("command").textContent);
plotlyReady.then(() => {
  const here = inside(...D.own) ? margin(...D.own) : { i: 0, j: 0 };
  if (rest.length) pick(nearest[here.i * side + here.j]); else draw();
  $("field").onchange = draw;
  $("map").on("plotly_hover", ({ points: [{ pointIndex: [i, j] }] }) => rows("here", [...place(load(i), speed(j)), ...numbers(near(i, j)).slice(1)]));
  $("map").on("plotly_click", ({ points: [{ pointIndex: [i, j] }] }) => pick(nearest[i * side + j]));
}).catch((error) => {
  $("map").textContent = "This browser cannot draw the map (it needs DecompressionStream); map.png shows it.";
  throw error;
});
