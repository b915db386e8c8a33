// SPDX-License-Identifier: Apache-2.0
// Orbits of the marks, seen along the hole.
import { COLOURS, ROCK, paper } from "./canvas.js";
import { $, element, state } from "./state.js";
import { text } from "./units.js";

export function beginOrbits(scene) {
  $("orbits").replaceChildren(...Object.keys(scene.clearance).map((name) => {
    const canvas = element("canvas", { id: `orbit_${name}` });
    canvas.style.aspectRatio = "1";
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `orbit of ${name}`);
    return element("figure", {}, canvas, element("figcaption", { id: `caption_${name}` }));
  }));
}

export function showOrbits(picture) {
  for (const mark of picture.marks) {
    const caption = $(`caption_${mark.name}`);
    if (!caption) continue;
    const precession = mark.precession === undefined || mark.precession === null ? "-" : `${mark.precession >= 0 ? "+" : ""}${text(mark.precession, "rotation")}`;
    caption.replaceChildren(element("b", { textContent: mark.name }), ` radius ${text(mark.orbit, "offset")}, whirl ${precession}`, element("br"), mark.motion || "");
  }
}

export function drawOrbits() {
  const { picture } = state;
  if (!picture?.scene) return;
  picture.marks.forEach((mark, k) => {
    const canvas = $(`orbit_${mark.name}`);
    if (!canvas) return;
    const [pen, width] = paper(canvas), wall = picture.scene.walls[mark.name], scale = width / 2 / (1.05 * wall), at = ([x, y]) => [width / 2 + scale * x, width / 2 - scale * y];
    const circle = (radius) => { pen.beginPath(); pen.arc(width / 2, width / 2, scale * radius, 0, 7); pen.stroke(); };
    pen.strokeStyle = ROCK; pen.lineWidth = 1.5; circle(wall);
    pen.strokeStyle = `${ROCK}66`; pen.setLineDash([4, 4]); circle(picture.scene.clearance[mark.name]); pen.setLineDash([]);
    const trail = state.trails[mark.name] || [];
    pen.lineWidth = 1.6; pen.strokeStyle = COLOURS[k % 5];
    for (let i = 1; i < trail.length; i++) { pen.globalAlpha = 0.1 + 0.9 * i / trail.length; pen.beginPath(); pen.moveTo(...at(trail[i - 1])); pen.lineTo(...at(trail[i])); pen.stroke(); }
    pen.globalAlpha = 1;
    if (mark.x !== undefined) { pen.fillStyle = COLOURS[k % 5]; pen.beginPath(); pen.arc(...at([mark.x, mark.y]), 5, 0, 7); pen.fill(); }
  });
}
