// SPDX-License-Identifier: Apache-2.0
// Lamps of whirl and stick-slip, alarms with their acknowledgement, and the log of events.
import { $, element, replace, state } from "./state.js";
import { say } from "./connection.js";

const SHOWN = 200;
let announced = 0;

function lamp(id, { level, text, severity }) {
  const box = $(id);
  box.className = `lamp level_${level}`;
  box.querySelector("b").textContent = text;
  box.querySelector("span").textContent = severity;
  box.setAttribute("aria-label", [box.querySelector("h2").textContent, [text, severity].filter(Boolean).join(", ")].join(": "));
}

export function showAlarms(picture) {
  lamp("lamp_whirl", picture.lamps.whirl);
  lamp("lamp_stick_slip", picture.lamps.stick_slip);
  const waiting = picture.alarms.filter((alarm) => !alarm.acknowledged);
  $("acknowledge_all").disabled = !waiting.length;
  replace($("alarms"), picture.alarms, () => picture.alarms.length ? picture.alarms.map((alarm) => {
    const time = alarm.time === null ? "" : `t = ${alarm.time.toFixed(1)} s: `, over = alarm.active ? "" : " (over)";
    const end = alarm.acknowledged ? element("span", { textContent: "acknowledged" }) : element("button", {
      type: "button", className: "quiet", textContent: "acknowledge", "aria-label": `acknowledge: ${alarm.text}`,
      onclick: () => say({ acknowledge: alarm.number }),
    });
    return element("li", { className: `level_${alarm.level}${alarm.acknowledged ? " acknowledged" : ""}` }, element("span", { textContent: `${alarm.level > 1 ? "alarm" : "warning"}, ${time}${alarm.text}${over}` }), end);
  }) : [element("li", { className: "none", textContent: "no alarms" })]);
  document.title = waiting.length ? `(${waiting.length}) ${picture.scene?.name ?? "drill_twin"}` : picture.scene?.name ?? "drill_twin";
  const fresh = waiting.filter((alarm) => alarm.number > announced);
  if (fresh.length) { announced = Math.max(...fresh.map((alarm) => alarm.number)); $("announced").textContent = fresh.map((alarm) => alarm.text).join("; "); }
  const events = state.events.slice(-SHOWN).reverse();
  replace($("events"), events[0]?.number ?? 0, () => events.map((event) => element("li", { className: `level_${event.level}`, textContent: `${event.clock}${event.time === null ? "" : ` t = ${event.time.toFixed(1)} s`} ${event.text}`.trim() })));
}

export const eventsTable = () => [["clock", "time [s]", "level", "event"], ...state.events.map((event) => [event.clock, event.time ?? "", event.level, `"${event.text.replaceAll('"', '""')}"`])].map((row) => row.join(",")).join("\n") + "\n";

$("acknowledge_all").addEventListener("click", () => say({ acknowledge: true }));
