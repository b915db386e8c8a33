// SPDX-License-Identifier: Apache-2.0
// The interactive view: the string in the hole (3-D, lateral axes stretched) and the orbits of the marks, in step.
"use strict";

(async function () {
  const box = document.getElementById("view");
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const INK = "#222222", GREY = "#8a8a8a";

  function bytes(text) {
    const plain = atob(text);
    const result = new Uint8Array(plain.length);
    for (let i = 0; i < plain.length; i++) result[i] = plain.charCodeAt(i);
    return result;
  }

  async function loadPlotly() {
    const packed = bytes(document.getElementById("plotly-packed").textContent.trim());
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.appendChild(script);
  }

  function unpack(text) { return new Int16Array(bytes(text).buffer); }

  // Index of the last entry of rising `times` that is not after `t`.
  function before(times, t) {
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  const mm = 1e3 * data.radius / data.full, metre = data.length / data.full;
  const shapes = unpack(data.shapes.values), points = data.shapes.points;
  const paths = unpack(data.paths.values), count = data.marks.length;

  function shapeAt(t) {
    const frame = before(data.shapes.time, t), x = [], y = [], z = [];
    for (let i = frame * points * 3; i < (frame + 1) * points * 3; i += 3) {
      x.push(mm * shapes[i]); y.push(mm * shapes[i + 1]); z.push(metre * shapes[i + 2]);
    }
    return { x, y, z };
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
    const x = [], y = [], z = [], radius = 1e3 * data.radius;
    for (let k = 0; k <= 5; k++) {
      for (let a = 0; a <= 72; a++) {
        x.push(radius * Math.cos(a * Math.PI / 36)); y.push(radius * Math.sin(a * Math.PI / 36));
        z.push(-data.length * k / 5);
      }
      x.push(null); y.push(null); z.push(null);
    }
    return { x, y, z };
  }

  const slider = document.getElementById("view-time"), label = document.getElementById("view-label");
  const button = document.getElementById("view-play"), pace = document.getElementById("view-pace");
  const trail = document.getElementById("view-trail");
  const end = data.shapes.time[data.shapes.time.length - 1];
  let now = end, playing = false, stamp = 0;

  function traces(t) {
    const line = shapeAt(t), tracks = pathsAt(t, Number(trail.value)), three = [], two = [];
    three.push({ type: "scatter3d", mode: "lines", hoverinfo: "skip", showlegend: false, ...rings(),
                 line: { color: GREY, width: 1 } });
    three.push({ type: "scatter3d", mode: "lines", name: "string", ...line, line: { color: INK, width: 7 },
                 hovertemplate: "x %{x:.1f} mm<br>y %{y:.1f} mm<br>z %{z:.2f} m<extra></extra>" });
    tracks.forEach((track, m) => {
      const colour = data.colours[m], name = data.marks[m];
      three.push({ type: "scatter3d", mode: "lines", ...track, name, line: { color: colour, width: 3 } });
      two.push({ type: "scatter", mode: "lines", x: track.x, y: track.y, name, legendgroup: name,
                 line: { color: colour, width: 1.5 } });
      two.push({ type: "scatter", mode: "markers", x: track.x.slice(-1), y: track.y.slice(-1), name,
                 legendgroup: name, showlegend: false, marker: { color: colour, size: 10, line: { color: INK, width: 1 } } });
    });
    return { three, two };
  }

  function circle(radius, line) {
    return { type: "circle", x0: -radius, y0: -radius, x1: radius, y1: radius, line };
  }

  function draw() {
    const edge = 1.06e3 * data.radius, { three, two } = traces(now);
    const common = { font: { family: "system-ui, sans-serif", size: 13, color: INK }, uirevision: "same",
                     paper_bgcolor: "white", showlegend: false };
    const side = (text) => ({ title: { text }, range: [-edge, edge], showbackground: false, gridcolor: "#e6e6e6",
                              zeroline: false, nticks: 5 });
    const options = { displaylogo: false, responsive: true, displayModeBar: false };
    Plotly.react("view-3d", three, { ...common, margin: { l: 0, r: 0, t: 0, b: 0 }, scene: {
      xaxis: side("x [mm]"), yaxis: side("y [mm]"),
      zaxis: { title: { text: "z [m]" }, range: [-data.length, 0], showbackground: false, gridcolor: "#e6e6e6" },
      aspectmode: "manual", aspectratio: { x: 0.8, y: 0.8, z: 1.6 },
      camera: { eye: { x: 1.6, y: -1.9, z: 0.55 }, center: { x: 0, y: 0, z: -0.08 } } } }, options);
    Plotly.react("view-2d", two, { ...common, showlegend: true,
      legend: { orientation: "h", x: 0.5, xanchor: "center", y: 1.02, yanchor: "bottom" },
      margin: { l: 55, r: 10, t: 30, b: 45 },
      xaxis: { title: { text: "x [mm]" }, range: [-edge, edge], gridcolor: "#eeeeee", zeroline: false },
      yaxis: { title: { text: "y [mm]" }, range: [-edge, edge], scaleanchor: "x", gridcolor: "#eeeeee", zeroline: false },
      shapes: [circle(1e3 * data.radius, { color: INK, width: 2.5 }),
               ...[...new Set(data.clearance)].map((c) => circle(1e3 * c, { color: GREY, width: 1, dash: "dot" }))] }, options);
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
    await loadPlotly();
    slider.max = end; slider.step = "any";
    draw();
    box.classList.add("ready");
  } catch (error) {
    console.error(error);
    box.classList.add("failed");
  }
})();
