// SPDX-License-Identifier: Apache-2.0
// Units of the reader's choice. Values come in SI units, speeds of rotation in rev/s; they are converted only where they are shown or typed.
import { $, element } from "./state.js";
import { SYSTEMS, UNITS } from "./unit_table.js";  // by quantity and unit: its size in the unit of the server, digits

const PLACE = "drill_twin units";
let chosen = null, listeners = [];

export const unit = (quantity) => (chosen ?? SYSTEMS.lab)[quantity];
export const size = (quantity) => UNITS[quantity][unit(quantity)][0];
// A number that would round to nothing gets a few more digits than usual; a zero has no sign.
export function number(value, quantity, extra = 2) {
  if (value === null || value === undefined) return "-";
  const scaled = value / size(quantity), usual = Math.abs(scaled) < 1e3 ? UNITS[quantity][unit(quantity)][1] : 0;
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

// Takes the units that `--units` asks for, else the units chosen here before, else the scene's.
export function unitsFor(scene, asked) { if (asked || !remembered()) choose(SYSTEMS[asked || scene.units], false); }

export function offerUnits() {
  $("units").append(...[...Object.keys(SYSTEMS), "own"].map((name) => element("option", { value: name, textContent: name, hidden: name === "own" })));
  $("unit_choices").append(...Object.entries(UNITS).map(([quantity, units]) => element("label", {}, quantity, element("select", { id: `unit_${quantity}` },
    ...Object.keys(units).map((name) => element("option", { value: name, textContent: name }))))));
  $("units").addEventListener("change", () => choose(SYSTEMS[$("units").value]));
  for (const quantity of Object.keys(UNITS)) $(`unit_${quantity}`).addEventListener("change", () => choose({ ...chosen, [quantity]: $(`unit_${quantity}`).value }));
  choose(remembered() ?? SYSTEMS.lab, false);
}
