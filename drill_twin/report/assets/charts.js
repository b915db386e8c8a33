// SPDX-License-Identifier: Apache-2.0
// Charts in place of the pictures: they take the width of the page, zoom, and show the values under the pointer.
// Each is drawn when it comes near the screen. Without plotly the pictures stay; they are also what is printed.
"use strict";

plotlyReady.then(() => {
  const charts = JSON.parse(document.getElementById("chart-data").textContent);
  const touch = matchMedia("(pointer: coarse)").matches;  // a finger on a chart scrolls the page
  const drawn = new Set();  // panels over time
  let range = null, busy = false;

  function draw(box, panel) {
    const { xaxis, yaxis } = panel.layout, upright = yaxis.range[0] > yaxis.range[1];  // a track over depth
    const narrow = upright && panel.width < 1.6;
    const names = narrow ? 0 : panel.traces.filter((one) => one.showlegend).length;
    if (box.clientWidth < 500) box.style.height = `${parseFloat(box.style.height) + 18 * names}px`;  // names one below the other
    const layout = {
      font: { family: "system-ui, sans-serif", size: 12, color: "#222222" }, paper_bgcolor: "white",
      margin: { l: 46, r: touch && !narrow ? 36 : 10, t: names > 1 ? 26 : 18, b: 40 }, dragmode: touch ? false : "zoom",
      hoverdistance: 30, modebar: { orientation: "v" }, showlegend: names > 1,
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" }, ...panel.layout,
    };
    if (narrow) Object.assign(xaxis, { nticks: 3, tickangle: 0 });
    const time = box.dataset.time === "true";
    if (time && range) xaxis.range = range.slice();
    Plotly.newPlot(box, panel.traces, layout, { displaylogo: false, responsive: true, displayModeBar: touch && !narrow,
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
    const box = document.querySelector(`.chart[data-name="${name}"]`), time = chart.panels.at(-1).layout.xaxis.title.text === "time [s]";
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
