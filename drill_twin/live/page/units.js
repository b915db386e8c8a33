// SPDX-License-Identifier: Apache-2.0
// Units of the reader's choice. Values come in SI units, speeds of rotation in rev/s; they are converted only where they are shown or typed.
import { $, element } from "./state.js";

const FOOT = 0.3048, POUND = 4.4482216152605;
const UNITS = {  // quantity: unit: [size in the unit of the server, digits]
  force: { N: [1, 1], kN: [1e3, 1], klbf: [1e3 * POUND, 1], t: [9806.65, 1] },
  rotation: { "rev/s": [1, 2], rpm: [1 / 60, 0] },
  torque: { "N m": [1, 3], "kN m": [1e3, 2], "kft lbf": [1e3 * FOOT * POUND, 2] },
  rate: { "m/h": [1 / 3600, 1], "ft/h": [FOOT / 3600, 1] },
  length: { m: [1, 1], ft: [FOOT, 0] },
  offset: { mm: [1e-3, 1], in: [0.0254, 2] },
  stress: { MPa: [1e6, 2], ksi: [1e3 * POUND / 0.0254 ** 2, 2] },
};
const SYSTEMS = {
  laboratory: { force: "N", rotation: "rev/s", torque: "N m", rate: "m/h", length: "m", offset: "mm", stress: "MPa" },
  SI: { force: "kN", rotation: "rpm", torque: "kN m", rate: "m/h", length: "m", offset: "mm", stress: "MPa" },
  field: { force: "klbf", rotation: "rpm", torque: "kft lbf", rate: "ft/h", length: "ft", offset: "in", stress: "ksi" },
};
const PLACE = "drill_twin units";
let chosen = null, listeners = [];

export const unit = (quantity) => (chosen ?? SYSTEMS.laboratory)[quantity];
export const size = (quantity) => UNITS[quantity][unit(quantity)][0];
export const digits = (quantity) => UNITS[quantity][unit(quantity)][1];
// A few more digits than usual for what would round to nothing; no sign before a zero.
export function number(value, quantity, extra = 2) {
  if (value === null || value === undefined) return "-";
  const scaled = value / size(quantity), usual = Math.abs(scaled) < 1e3 ? digits(quantity) : 0;
  let more = usual;
  while (more < usual + extra && Math.abs(scaled) < 10 ** (1 - more)) more += 1;
  return Math.abs(scaled) < 0.5 * 10 ** -more ? (0).toFixed(usual) : scaled.toFixed(more);
}
export const text = (value, quantity) => value === null || value === undefined ? "-" : `${number(value, quantity)} ${unit(quantity)}`;
export const onUnits = (listener) => { listeners.push(listener); };

function choose(units, keep = true) {
  chosen = { ...units };
  $("units").value = Object.keys(SYSTEMS).find((name) => Object.keys(UNITS).every((quantity) => SYSTEMS[name][quantity] === chosen[quantity])) ?? "own";
  for (const quantity of Object.keys(UNITS)) $(`unit_${quantity}`).value = chosen[quantity];
  if (keep) try { localStorage.setItem(PLACE, JSON.stringify(chosen)); } catch { /* a browser without storage forgets */ }
  for (const listener of listeners) listener();
}

function remembered() {
  try {
    const kept = JSON.parse(localStorage.getItem(PLACE));
    return kept && Object.keys(UNITS).every((quantity) => kept[quantity] in UNITS[quantity]) ? kept : null;
  } catch { return null; }
}

// Without a choice, a string of more than 100 m has the units of a rig.
export function unitsFor(scene) { if (!remembered()) choose(scene.length > 100 ? SYSTEMS.SI : SYSTEMS.laboratory, false); }

export function offerUnits() {
  $("units").append(...[...Object.keys(SYSTEMS), "own"].map((name) => element("option", { value: name, textContent: name, hidden: name === "own" })));
  $("unit_choices").append(...Object.entries(UNITS).map(([quantity, units]) => element("label", {}, quantity, element("select", { id: `unit_${quantity}` },
    ...Object.keys(units).map((name) => element("option", { value: name, textContent: name }))))));
  $("units").addEventListener("change", () => choose(SYSTEMS[$("units").value]));
  for (const quantity of Object.keys(UNITS)) $(`unit_${quantity}`).addEventListener("change", () => choose({ ...chosen, [quantity]: $(`unit_${quantity}`).value }));
  choose(remembered() ?? SYSTEMS.laboratory, false);
}
