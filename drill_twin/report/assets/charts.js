// SPDX-License-Identifier: Apache-2.0
// Charts in place of the pictures: they take the width of the page, zoom, and show the values under the pointer.
// Each is drawn when it comes near the screen. Without plotly the pictures stay; they are also what is printed.
"use strict";

plotlyReady.then(() => {
  const charts = JSON.parse(document.getElementById("chart-data").textContent);
  const touch = matchMedia("(pointer: coarse)").matches;  // a finger on a chart scrolls the page
  // Numbers in base64, or first, step and count.
  const numbers = (from) => Array.isArray(from) ? Float64Array.from({ length: from[2] }, (_, k) => from[0] + k * from[1])
    : new Float32Array(bytes(from).buffer);
  const drawn = new Set();  // panels over time
  let range = null, busy = false;

  const title = (text) => ({ text: text.replace(/\n/g, "<br>"), standoff: 6 });

  function axis(from) {
    const found = { title: title(from.label), range: from.range.slice(), gridcolor: "#e6e6e6", zeroline: false, automargin: true };
    if (from.log) found.type = "log";
    if (from.names) Object.assign(found, { tickvals: from.ticks, ticktext: from.names });
    return found;
  }

  function trace(from) {
    if (from.kind === "mesh") {
      const flat = Array.from(bytes(from.values), (share) => from.low + (from.high - from.low) * share / 255), z = [], rows = flat.length / from.columns;
      for (let row = 0; row < rows; row++) z.push(flat.slice(row * from.columns, (row + 1) * from.columns));
      return { type: "heatmap", x: numbers(from.x), y: numbers(from.y), z, customdata: z.map((row) => row.map((value) => 10 ** value)),
               zmin: from.low, zmax: from.high, colorscale: [[0, "#ffffff"], [1, "#000000"]], showscale: false,
               hovertemplate: "%{x:.2f} s, %{y:.2f} Hz: %{customdata:.3g}<extra></extra>" };
    }
    const found = { type: "scatter", mode: "lines", x: numbers(from.x), y: numbers(from.y), name: from.name, showlegend: from.name !== "" };
    if (from.kind === "area") {
      return { ...found, fill: "toself", fillcolor: from.colour, line: { width: 0 }, hoverinfo: from.text ? "text" : "skip",
               hoveron: "fills", text: from.text };
    }
    Object.assign(found, { opacity: from.opacity, line: { color: from.colour, width: from.width, dash: from.dash } });
    if (from.name === "") found.hoverinfo = "skip";
    if (from.marker) Object.assign(found, { mode: "markers", marker: { color: from.colour, size: 1 + from.marker } });
    return found;
  }

  function across(from) {
    const along = from.upright ? { x0: from.at, x1: from.at, yref: "paper", y0: 0, y1: 1 } : { y0: from.at, y1: from.at, xref: "paper", x0: 0, x1: 1 };
    return { type: "line", ...along, line: { color: from.colour, width: from.width, dash: from.dash },
             label: { text: from.name, textangle: 0, textposition: "end", font: { color: from.colour } } };
  }

  function draw(box, panel) {
    const upright = panel.y.range[0] > panel.y.range[1];  // a track over depth
    const narrow = upright && panel.width < 1.6;
    const lines = panel.traces.filter((from) => from.kind === "across"), traces = panel.traces.filter((from) => from.kind !== "across").map(trace);
    for (const one of traces.filter((area) => area.text)) {  // a state is named once
      one.name = one.legendgroup = one.text.split(",")[0];
      one.showlegend = !traces.some((other) => other.showlegend && other.name === one.name);
    }
    const names = narrow ? 0 : traces.filter((one) => one.showlegend).length;
    if (box.clientWidth < 500) box.style.height = `${parseFloat(box.style.height) + 18 * names}px`;  // names one below the other
    const layout = {
      font: { family: "system-ui, sans-serif", size: 12, color: "#222222" }, paper_bgcolor: "white",
      margin: { l: 46, r: touch && !narrow ? 36 : 10, t: names > 1 ? 26 : 18, b: 40 }, dragmode: touch ? false : "zoom",
      hovermode: upright ? "y unified" : panel.equal || panel.y.names ? "closest" : "x unified", hoverdistance: 30, modebar: { orientation: "v" },
      xaxis: axis(panel.x), yaxis: axis(panel.y), shapes: lines.map(across), showlegend: names > 1,
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" },
    };
    if (narrow) Object.assign(layout.xaxis, { nticks: 3, tickangle: 0 });
    if (panel.equal) layout.yaxis.scaleanchor = "x";
    if (traces.some((one) => one.type === "heatmap")) layout.hovermode = "closest";
    const time = box.dataset.time === "true";
    if (time && range) layout.xaxis.range = range.slice();
    Plotly.newPlot(box, traces, layout, { displaylogo: false, responsive: true, displayModeBar: touch && !narrow,
                   modeBarButtons: [["zoomIn2d", "zoomOut2d", "resetScale2d"]] });
    if (!time) return;
    drawn.add(box);
    box.on("plotly_relayout", (change) => {  // all panels over time show the same part of the run
      const now = change["xaxis.range[0]"] === undefined ? change["xaxis.range"] : [change["xaxis.range[0]"], change["xaxis.range[1]"]];
      if (busy || !now) return;
      busy = true; range = now.slice();
      Promise.all([...drawn].filter((other) => other !== box).map((other) => Plotly.relayout(other, { "xaxis.range": range.slice() })))
        .finally(() => { busy = false; });
    });
  }

  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) { near.unobserve(entry.target); draw(entry.target, entry.target.panel); }
  }, { rootMargin: "500px" });

  for (const [name, chart] of Object.entries(charts)) {
    const box = document.querySelector(`.chart[data-name="${name}"]`), time = chart.panels[chart.panels.length - 1].x.label === "time [s]";
    const head = document.createElement("h3");
    head.textContent = chart.title; box.append(head);
    for (const panel of chart.panels) {
      const cell = document.createElement("div"), words = document.createElement("p"), plot = document.createElement("div");
      cell.className = "cell"; cell.style.flex = `${panel.width} 1 ${panel.width > 3 ? "100%" : panel.width > 1.6 ? "240px" : "130px"}`;
      words.textContent = panel.title; plot.style.height = `${Math.max(170, 90 * panel.height + 60)}px`;
      plot.panel = panel; plot.dataset.time = time;
      cell.append(words, plot); box.append(cell); near.observe(plot);
    }
    box.closest(".both").classList.add("charted");
  }
}).catch((error) => console.error(error));
