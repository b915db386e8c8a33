// SPDX-License-Identifier: Apache-2.0
// The interactive view: the string in the well as it is drilled (3-D, widths exaggerated) and the orbits, in step.
"use strict";

(async function () {
  const box = document.getElementById("view");
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const INK = "#222222", GREY = "#8a8a8a";

  function unpack(text) { return new Int16Array(bytes(text).buffer); }

  // Index of the last entry of rising `times` that is not after `t`.
  function before(times, t) { return Math.max(times.findLastIndex((time) => time <= t), 0); }

  const mm = 1e3 * data.radius / data.full, metre = data.length / data.full;
  const shapes = unpack(data.shapes.values), points = data.shapes.points;
  const paths = unpack(data.paths.values), count = data.marks.length;

  const well = data.well, sides = 12;
  const [long, lengthUnit] = data.units.length, [wide, offsetUnit] = data.units.offset, across = 1e-3 * wide;  // of a metre, of a mm
  const sizes = well.deviated ? [long, long, long] : [across, across, long];
  const digits = offsetUnit === "mm" ? 1 : 2;

  // Point in the picture, in its units, from x and y off the axis of the hole [mm] and its measured depth [m].
  function place(x, y, depth) {
    const at = Math.min(before(well.depth, depth), well.depth.length - 2);
    const step = well.depth[at + 1] - well.depth[at], share = step > 0 ? (depth - well.depth[at]) / step : 0;
    const between = (rows, c) => rows[at][c] + share * (rows[at + 1][c] - rows[at][c]), scale = 1e-3 * well.factor;
    return [0, 1, 2].map((c) => between(well.centre, c) + scale * (x * between(well.x, c) + y * between(well.y, c))).map((value, c) => sizes[c] * value);
  }

  // Tube with a radius [mm] at each of its points, as a surface.
  function tube(middle, radius, looks) {
    const surface = { type: "surface", x: [], y: [], z: [], showscale: false, contours: {}, ...looks };
    middle.forEach(([x, y, depth], i) => {
      const ring = [];
      for (let a = 0; a <= sides; a++) {
        const turn = 2 * Math.PI * a / sides;
        ring.push(place(x + radius[i] * Math.cos(turn), y + radius[i] * Math.sin(turn), depth));
      }
      ["x", "y", "z"].forEach((name, c) => surface[name].push(ring.map((point) => point[c])));
    });
    return surface;
  }

  const plain = (colour) => ({ colorscale: [[0, colour], [1, colour]], lighting: { ambient: 0.7, diffuse: 0.5, specular: 0.1 } });
  const wall = tube(well.depth.map((depth) => [0, 0, depth]), well.hole.map((radius) => 1e3 * radius),
                    { ...plain("#a08060"), opacity: 0.18, hoverinfo: "skip" });
  const holeAt = (depth) => 1e3 * well.hole[before(well.depth, depth)];

  const said = (mm) => `${(across * mm).toFixed(digits)} ${offsetUnit}`;

  function stringAt(t) {
    const frame = before(data.shapes.time, t), middle = [], words = [];
    for (let i = frame * points * 3, k = 0; k < points; i += 3, k++) {
      const [x, y, depth] = [mm * shapes[i], mm * shapes[i + 1], -metre * shapes[i + 2]];
      const gap = holeAt(depth) - 1e3 * data.pipe[k] - Math.hypot(x, y);
      middle.push([x, y, depth]);
      words.push(Array(sides + 1).fill(`measured depth ${(long * depth).toFixed(2)} ${lengthUnit}<br>${said(Math.hypot(x, y))} off ` +
        `the axis<br>${said(gap)} to the wall<br>diameter ${said(2e3 * data.pipe[k])}`));
    }
    return tube(middle, data.pipe.map((radius) => 1e3 * radius),
                { ...plain("#4a4f57"), text: words, hoverinfo: "text", name: "string" });
  }

  function pathsAt(t, seconds) {
    const last = before(data.paths.time, t), first = before(data.paths.time, t - seconds), result = [];
    for (let m = 0; m < count; m++) {
      const x = [], y = [], z = [];
      for (let i = first; i <= last; i++) {
        const at = 3 * (i * count + m);
        x.push(mm * paths[at]); y.push(mm * paths[at + 1]); z.push(metre * paths[at + 2]);
      }
      result.push({ x, y, z });
    }
    return result;
  }

  function rings() {
    const line = { x: [], y: [], z: [] };
    for (const depth of well.rings) {
      for (let a = 0; a <= 72; a++) {
        const radius = holeAt(depth), turn = a * Math.PI / 36;
        place(radius * Math.cos(turn), radius * Math.sin(turn), depth).forEach((value, c) => line["xyz"[c]].push(value));
      }
      for (const name of "xyz") line[name].push(null);
    }
    return line;
  }

  const circles = { type: "scatter3d", mode: "lines", hoverinfo: "skip", ...rings(), line: { color: GREY, width: 1 } };
  const slider = document.getElementById("view-time"), label = document.getElementById("view-label");
  const button = document.getElementById("view-play"), pace = document.getElementById("view-pace");
  const trail = document.getElementById("view-trail");
  const end = data.shapes.time[data.shapes.time.length - 1];
  let now = end, playing = false, stamp = 0;

  function traces(t) {
    const tracks = pathsAt(t, Number(trail.value)), three = [wall, circles, stringAt(t)], two = [];
    tracks.forEach((track, m) => {
      const colour = data.colours[m], name = data.marks[m];
      const path = track.x.map((x, i) => place(x, track.y[i], -track.z[i])), [x, y, z] = [0, 1, 2].map((c) => path.map((p) => p[c]));
      three.push({ type: "scatter3d", mode: "lines", x, y, z, name, hoverinfo: "name", line: { color: colour, width: 3 } });
      const [seenX, seenY] = [track.x, track.y].map((row) => row.map((value) => across * value));
      two.push({ type: "scatter", mode: "lines", x: seenX, y: seenY, name, legendgroup: name,
                 line: { color: colour, width: 1.5 } });
      two.push({ type: "scatter", mode: "markers", x: seenX.slice(-1), y: seenY.slice(-1), name,
                 legendgroup: name, showlegend: false, marker: { color: colour, size: 10, line: { color: INK, width: 1 } } });
    });
    return { three, two };
  }

  // A long string: distance from the axis over measured depth, in two panels, first the assembly.
  function flat(t) {
    const frame = before(data.shapes.time, t), result = [];
    for (const c of [0, 1]) {
      const at = { xaxis: c ? "x2" : "x", yaxis: "y", hoverinfo: "skip", mode: "lines", showlegend: false };
      const depth = well.depth.map((d) => long * d), hole = well.hole.map((r) => wide * r);
      result.push({ ...at, x: [...hole, ...hole.map((r) => -r).reverse()], y: [...depth, ...depth.slice().reverse()], fill: "toself",
                    fillcolor: "#e8e0d6", line: { color: INK, width: 1.5 } });
      const middle = [], near = [], far = [], deep = [];
      for (let i = frame * points * 3, k = 0; k < points; i += 3, k++) {
        const off = across * mm * shapes[i + c], pipe = wide * data.pipe[k];
        middle.push(off); near.push(off - pipe); far.push(off + pipe); deep.push(-long * metre * shapes[i + 2]);
      }
      result.push({ ...at, x: [...near, ...far.slice().reverse()], y: [...deep, ...deep.slice().reverse()], fill: "toself",
                    fillcolor: "rgba(0,114,178,0.35)", line: { width: 0 } });
      result.push({ ...at, x: middle, y: deep, line: { color: "#0072b2", width: 2 }, hoverinfo: "x+y" });
    }
    return result;
  }

  function circle(radius, line) {
    return { type: "circle", x0: -radius, y0: -radius, x1: radius, y1: radius, line };
  }

  function draw() {
    const edge = 1.06 * wide * Math.max(...data.walls), { three, two } = traces(now);
    const common = { font: { family: "system-ui, sans-serif", size: 13, color: INK }, uirevision: "same",
                     paper_bgcolor: "white", showlegend: false };
    const axis = (c, more) => ({ title: { text: well.names[c] }, showbackground: false, gridcolor: "#e6e6e6",
                                 zeroline: false, nticks: 6, ...more });
    const width = { range: [-1.06 * wide * data.radius, 1.06 * wide * data.radius], nticks: 5 };
    const scene = well.deviated ? { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2, { autorange: "reversed" }), aspectmode: "data" }
      : { xaxis: axis(0, width), yaxis: axis(1, width), zaxis: axis(2, { range: [-long * data.length, 0] }),
          aspectmode: "manual", aspectratio: { x: 0.8, y: 0.8, z: 1.6 } };
    const options = { displaylogo: false, responsive: true, displayModeBar: false };
    const side = (c) => ({ title: { text: `${"xy"[c]} [${offsetUnit}]` }, domain: c ? [0.54, 1] : [0, 0.46], nticks: 5,
                           range: [-1.06 * wide * data.radius, 1.06 * wide * data.radius], gridcolor: "#eeeeee", zeroline: false });
    if (well.flat) Plotly.react("view-3d", flat(now), { ...common, margin: { l: 62, r: 6, t: 10, b: 45 }, xaxis: side(0), xaxis2: side(1),
      yaxis: { title: { text: `measured depth [${lengthUnit}]` }, range: [long * data.length, long * data.top], gridcolor: "#eeeeee", zeroline: false } }, options);
    else Plotly.react("view-3d", three, { ...common, margin: { l: 0, r: 0, t: 0, b: 0 },
      scene: { ...scene, camera: { eye: { x: 1.75, y: -2.1, z: 0.6 }, center: { x: 0, y: 0, z: -0.1 } } } }, options);
    Plotly.react("view-2d", two, { ...common, showlegend: true,
      legend: { orientation: "h", x: 0.5, xanchor: "center", y: 1.02, yanchor: "bottom" },
      margin: { l: 55, r: 10, t: 30, b: 45 },
      xaxis: { title: { text: `x [${offsetUnit}]` }, range: [-edge, edge], gridcolor: "#eeeeee", zeroline: false },
      yaxis: { title: { text: `y [${offsetUnit}]` }, range: [-edge, edge], scaleanchor: "x", gridcolor: "#eeeeee", zeroline: false },
      shapes: [...[...new Set(data.walls)].map((radius) => circle(wide * radius, { color: INK, width: 2.5 })),
               ...[...new Set(data.clearance)].map((c) => circle(wide * c, { color: GREY, width: 1, dash: "dot" }))] }, options);
    slider.value = now;
    const after = data.onset === null ? "" : now < data.onset ? ", before the onset" : ", after the onset";
    label.textContent = `${now.toFixed(2)} s${after}`;
  }

  function turn(moment) {
    if (!playing) return;
    now += Number(pace.value) * Math.min((moment - stamp) / 1e3, 0.2);
    stamp = moment;
    if (now >= end) { now = end; stop(); }
    draw();
    requestAnimationFrame(turn);
  }

  function stop() { playing = false; button.textContent = "Play"; }

  button.addEventListener("click", () => {
    if (playing) { stop(); return; }
    if (now >= end) now = 0;
    playing = true; button.textContent = "Pause"; stamp = performance.now();
    requestAnimationFrame(turn);
  });
  slider.addEventListener("input", () => { stop(); now = Number(slider.value); draw(); });
  trail.addEventListener("change", draw);

  try {
    await plotlyReady;
    slider.max = end; slider.step = "any";
    draw();
    box.classList.add("ready");
  } catch (error) {
    console.error(error);
    box.classList.add("failed");
  }
})();
