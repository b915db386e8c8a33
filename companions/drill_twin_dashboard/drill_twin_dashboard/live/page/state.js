// SPDX-License-Identifier: Apache-2.0
// The newest picture of the server, what is kept of earlier ones, and small helpers.

const TRAIL = 400;  // positions of a mark

export const state = { picture: null, trails: {}, trends: { run: null, seconds: 0.25, channels: [], rows: [] }, events: [] };
export const $ = (id) => document.getElementById(id);

// Make an element with its properties, and with attributes that are no properties, as `aria-label`.
export function element(name, content = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(content)) if (key in made) made[key] = value; else made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// Replace the children of a list only if they say something else, so that a screen reader and the focus stay where they are.
const shown = new WeakMap();
export function replace(box, key, children) {
  const text = JSON.stringify(key);
  if (shown.get(box) === text) return;
  shown.set(box, text);
  box.replaceChildren(...children());
}

export function keepTrails(picture) {
  const before = state.picture;
  if (picture.time === null || (before && picture.time < before.time - 1e-9)) state.trails = {};
  for (const [name, places] of Object.entries(picture.trail)) state.trails[name] = (state.trails[name] || []).concat(places).slice(-TRAIL);
}

// Rows of the trends and events that are new; true if some before them are missing, so that all have to be asked for.
export function keepHistory({ trends, events }) {
  const held = state.trends, last = held.rows.at(-1)?.[0] ?? -1, fresh = trends.rows.filter((row) => row[0] > last);
  if (trends.run !== held.run) return true;
  held.rows.push(...fresh);
  const newest = state.events.at(-1)?.number ?? 0;
  state.events.push(...events.filter((event) => event.number > newest));
  return (trends.rows.length > 0 && trends.rows[0][0] > last + 1 && held.rows.length > fresh.length) || (events[0]?.number ?? 0) > newest + 1;
}

export const takeHistory = ({ trends, events }) => Object.assign(state, { trends, events });
