// SPDX-License-Identifier: Apache-2.0
// Pictures on canvases, in the resolution of the screen: the string in the hole, and the orbits of the marks seen along it.
// The string is drawn as it is drilled, seen from a direction that the pointer and the arrow keys turn.
import { $, element, state } from "./state.js";
import { text } from "./units.js";

const COLOURS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442"];
const ROCK = "#a08060", SOFT = "#a9afb8";

function paper(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
  const pen = canvas.getContext("2d"); pen.setTransform(ratio, 0, 0, ratio, 0, 0); pen.clearRect(0, 0, width, height);
  return [pen, width, height];
}

export function beginOrbits(scene) {
  $("orbits").replaceChildren(...Object.keys(scene.clearance).map((name) => element("figure", {},
    element("canvas", { id: `orbit_${name}`, role: "img", "aria-label": `orbit of ${name}`, style: "aspect-ratio: 1" }),
    element("figcaption", { id: `caption_${name}` }))));
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

let turn = 0.6, tilt = 0.25, held = null;

// Through all nodes, with the slope of their neighbours (Catmull and Rom): the elements are cubic, too.
function smooth(pen, dots, first, last) {
  pen.beginPath(); pen.moveTo(...dots[first]);
  for (let i = first; i < last; i++) {
    const [a, b, c, d] = [dots[Math.max(i - 1, 0)], dots[i], dots[i + 1], dots[Math.min(i + 2, dots.length - 1)]];
    pen.bezierCurveTo(b[0] + (c[0] - a[0]) / 6, b[1] + (c[1] - a[1]) / 6, c[0] - (d[0] - b[0]) / 6, c[1] - (d[1] - b[1]) / 6, ...c);
  }
  pen.stroke();
}

// The well seen from above by the tilt: points [right, near, down] of it, from x, y off the hole's axis [m] and the depth.
function wellView(well, factor) {
  const upright = well.deviated ? (row) => row : ([x, y, z]) => [x, -y, -z]; // north, east, down are right-handed; x, y, up are turned round
  const [centre, ex, ey] = [well.centre, well.x, well.y].map((rows) => rows.map(upright));
  return (x, y, depth) => {
    const low = Math.min(Math.max(well.depth.findLastIndex((station) => station <= depth), 0), well.depth.length - 2);
    const share = (depth - well.depth[low]) / (well.depth[low + 1] - well.depth[low]), at = (rows, c) => rows[low][c] + share * (rows[low + 1][c] - rows[low][c]);
    const [n, e, d] = [0, 1, 2].map((c) => at(centre, c) + factor * (x * at(ex, c) + y * at(ey, c)));
    return [n * Math.cos(turn) + e * Math.sin(turn), d * Math.cos(tilt) + (e * Math.cos(turn) - n * Math.sin(turn)) * Math.sin(tilt)];
  };
}

export function drawString() {
  const [pen, width, height] = paper($("string")), now = state.picture;
  if (!now?.scene || !now.nodes.length) return;
  const { length, well, string } = now.scene, margin = 26, widest = Math.max(...well.hole);
  // a vertical hole is drawn over the whole height, a deviated one as large as fits; widths are exaggerated in both
  const factor = well.deviated ? well.factor : 0.3 * width * length * Math.cos(tilt) / (widest * Math.max(height - 2 * margin - 0.6 * width * Math.sin(tilt), 50));
  const seen = wellView(well, factor), ring = (depth, radius) => Array.from({ length: 33 }, (_, k) => seen(radius * Math.cos(k * Math.PI / 16), radius * Math.sin(k * Math.PI / 16), depth));
  const radiusAt = (depth) => well.hole[Math.max(0, well.depth.findLastIndex((station) => station <= depth + 1e-9))];
  const rings = [...well.rings, ...now.marks.filter((mark) => mark.z !== undefined).map((mark) => Math.min(length, -mark.z))].map((depth) => ring(depth, radiusAt(depth)));
  const edge = rings.flat(), lefts = edge.map((dot) => dot[0]), downs = edge.map((dot) => dot[1]), [left, right, up, down] = [Math.min(...lefts), Math.max(...lefts), Math.min(...downs), Math.max(...downs)];
  const scale = Math.min((height - 2 * margin) / (down - up), (width - 110) / (right - left));
  const dot = ([x, y]) => [width / 2 + scale * (x - (left + right) / 2), height / 2 + scale * (y - (up + down) / 2)], place = (x, y, depth) => dot(seen(x, y, depth));
  $("scale").textContent = `(${well.deviated ? "as drilled, " : ""}widths x ${factor < 10 ? factor.toFixed(1) : Math.round(factor)})`;
  const line = (dots) => { pen.beginPath(); dots.forEach((at) => pen.lineTo(...at)); pen.stroke(); };
  pen.lineWidth = 1; pen.strokeStyle = `${ROCK}88`;
  const axis = well.depth.map((depth) => place(0, 0, depth));
  for (const side of [-1, 1]) line(axis.map(([x, y], k) => { // outlines, across the axis as it is seen
    const [a, b] = [axis[Math.max(k - 1, 0)], axis[Math.min(k + 1, axis.length - 1)]], run = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, off = side * scale * factor * well.hole[k];
    return [x + off * (b[1] - a[1]) / run, y - off * (b[0] - a[0]) / run];
  }));
  rings.forEach((dots, k) => { pen.strokeStyle = k < well.rings.length ? ROCK : `${ROCK}66`; line(dots.map(dot)); });
  pen.strokeStyle = "#c9ccd1"; pen.lineJoin = "round"; pen.lineCap = "butt";
  const nodes = now.nodes.map(([x, y, z]) => place(x, y, -z)), last = nodes.length - 1, node = (distance) => {
    let near = 0; now.nodes.forEach(([, , z], k) => { if (Math.abs(length + z - distance) < Math.abs(length + now.nodes[near][2] - distance)) near = k; }); return near;
  };
  for (const [begin, end, radius] of string) { // each part with its diameter
    const [first, until] = [begin === 0 ? 0 : node(begin), end >= length * (1 - 1e-9) ? last : node(end)];
    pen.lineWidth = Math.max(3, 2 * scale * factor * radius); if (until > first) smooth(pen, nodes, first, until);
  }
  pen.font = "13px system-ui, sans-serif";
  const lines = [];
  now.marks.forEach((mark, k) => {
    if (mark.z === undefined) return;
    const [x, y] = place(mark.x, mark.y, -mark.z); pen.fillStyle = COLOURS[k % 5]; pen.beginPath(); pen.arc(x, y, 6, 0, 7); pen.fill();
    const [at, high] = place(0, 0, -mark.z); let row = high + 4; while (lines.some((other) => Math.abs(other - row) < 13)) row += 14;
    lines.push(row); pen.fillText(mark.name, at + scale * factor * radiusAt(-mark.z) + 8, row);
  });
  pen.fillStyle = SOFT; for (const [name, depth] of [["bit", length], ["top", 0]]) { const [x, y] = place(0, 0, depth); pen.fillText(name, Math.max(4, x - scale * factor * radiusAt(depth) - 28), y + 4); }
}

function view(newTurn, newTilt) { turn = newTurn; tilt = Math.min(1.2, Math.max(0, newTilt)); }
const KEYS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.06], ArrowDown: [0, 0.06] };
$("string").addEventListener("keydown", (event) => { const by = KEYS[event.key]; if (by) { event.preventDefault(); view(turn + by[0], tilt + by[1]); } });
$("string").addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY, turn, tilt]; $("string").setPointerCapture(event.pointerId); });
$("string").addEventListener("pointermove", (event) => { if (held) view(held[2] + 0.008 * (event.clientX - held[0]), held[3] + 0.005 * (event.clientY - held[1])); });
$("string").addEventListener("pointerup", () => { held = null; });
