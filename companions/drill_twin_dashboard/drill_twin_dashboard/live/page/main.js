// SPDX-License-Identifier: Apache-2.0
// The page: each part takes from a picture of the server what it shows. `live/page_state.py` makes the pictures.
import { eventsTable, showAlarms } from "./alarms.js";
import { connect } from "./connection.js";
import { beginControls, offerControls, showControls } from "./controls.js";
import { drawMap } from "./map_view.js";
import { $, element, keepTrails, replace, state } from "./state.js";
import { offerTrends, showValues, trendsTable } from "./trends.js";
import { number, offerUnits, text, unitsFor } from "./units.js";
import { beginOrbits, drawOrbits, drawString, showOrbits } from "./views.js";

const ROWS = [["bit_rps", "bit speed", "rotation"], ["bit_torque", "bit torque", "torque"], ["drag", "drag", "force"]];
let sceneText = null, refused = "";

function show(picture) {
  keepTrails(picture);
  state.picture = picture;
  if (picture.scene && JSON.stringify(picture.scene) !== sceneText) begin(picture.scene, picture.units);
  showHead(picture);
  showMotion(picture);
  showValues(picture);
  showAlarms(picture);
  showControls(picture);
  showOrbits(picture);
  if (picture.refused !== undefined && picture.refused !== refused) $("trouble").textContent = refused = picture.refused;
  $("advice").hidden = !picture.map && !picture.advice?.text;
  tell("advice_text", picture.advice);
  const { estimates } = picture;
  $("estimates").hidden = !estimates;
  tell("estimate_text", estimates);
  $("estimate_rows").className = `level_${estimates?.trust ?? 0}`;
  const bands = (estimates?.rows ?? []).map(band);
  replace($("estimate_rows"), bands, () => bands.map((cells) => element("tr", {}, ...cells.map((textContent) => element("td", { textContent })))));
  replace($("values"), ROWS.map(([id, , quantity]) => text(picture.rig[id], quantity)), () => ROWS.map(([id, words, quantity]) => row(words, text(picture.rig[id], quantity))));
  replace($("graph"), picture.graph.map(({ name, text, level }) => [name, text, level]), () => picture.graph.map((node) => row(node.name, node.text, `level_${node.level}`)));
}

const tell = (id, said) => Object.assign($(id), { textContent: said?.text ?? "", className: `level_${said?.level ?? 0}` });

const row = (name, value, className = "") => element("tr", { className }, element("td", { textContent: name }), element("td", { textContent: value }));

const plain = (value) => value === null ? "unknown" : String(+value.toPrecision(4));

// Cells of an estimate: name, mean, and the band in the unit of the mean.
function band({ name, quantity, mean, low, high }) {
  if (quantity) return [name, text(mean, quantity), `${number(low, quantity)} to ${number(high, quantity)}`];
  return [name, plain(mean), low === null ? "" : `${plain(low)} to ${plain(high)}`];
}

function begin(scene, units) {
  sceneText = JSON.stringify(scene);
  state.trails = {};
  $("name").textContent = scene.name;
  $("bounds").textContent = `bounds of severity: ${scene.bounds}`;
  unitsFor(scene, units);
  beginOrbits(scene);
  beginControls(scene);
}

function showHead(picture) {
  $("time").textContent = picture.time === null ? "no time" : `t = ${picture.time.toFixed(2)} s`;
  $("factor").textContent = picture.simulator.factor ? `${(+picture.simulator.factor).toFixed(2)} x real time` : "";
  $("simulator").textContent = picture.simulator.text;
  for (const source of ["simulator", "analyzer"]) document.body.classList.toggle(`stale_${source}`, picture.ages[source] > 1);
}

function showMotion({ motion, onset, ages }) {
  const calm = !motion.whirls, began = () => `whirl began at ${onset.time?.toFixed(2) ?? "-"} s at ${onset.mark}${calm ? "; the string does not whirl now" : ""}`;
  $("motion").textContent = motion.state || "unknown";
  $("criterion").textContent = motion.criterion;
  $("onset").textContent = onset ? began() : ages.analyzer > 3 ? "" : "no onset of whirl so far";
  $("onset").className = onset && !calm ? "found" : "";
}

function save(name, table) {
  const link = element("a", { download: `${state.picture?.scene?.name ?? "drill_twin"}_${name}.csv`, href: URL.createObjectURL(new Blob([table], { type: "text/csv" })) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function draw() { drawString(); drawOrbits(); drawMap(); requestAnimationFrame(draw); }

offerTrends();
offerControls();
offerUnits();
$("export_trends").addEventListener("click", () => save("trends", trendsTable()));
$("export_events").addEventListener("click", () => save("events", eventsTable()));
connect(show, (sentence) => { $("trouble").textContent = sentence; });
draw();
