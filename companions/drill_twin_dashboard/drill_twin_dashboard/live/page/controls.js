// SPDX-License-Identifier: Apache-2.0
// Set-points by slider and by number, pause, step and reset of a twin, and the playback of a recording.
import { $, state } from "./state.js";
import { say } from "./connection.js";
import { onUnits, size, unit } from "./units.js";

const SET_POINTS = { wob: "force", rps: "rotation" }, HELD = 2500, SURE = 4000;  // ms
const touched = { wob: 0, rps: 0, seek: 0 }, due = {};
let opened = false, sure = null, paused = false, playing = false;

const rounded = (value, quantity) => +(value / size(quantity)).toPrecision(4);

function command(name, value) {
  touched[name] = Date.now();
  clearTimeout(due[name]);
  due[name] = setTimeout(() => say({ [name]: value }), 120);
}

export function offerControls() {
  for (const [name, quantity] of Object.entries(SET_POINTS)) {
    $(`${name}_slider`).addEventListener("input", () => {  // read now: the next picture moves the slider too
      const value = +$(`${name}_slider`).value;
      $(`${name}_entry`).value = rounded(value, quantity);
      command(name, value);
    });
    $(`${name}_form`).addEventListener("submit", (event) => {
      event.preventDefault();
      if ($(`${name}_entry`).value !== "") command(name, +$(`${name}_entry`).value * size(quantity));
    });
    $(`${name}_entry`).addEventListener("input", () => { touched[name] = Infinity; });  // until it is set, or left
    $(`${name}_entry`).addEventListener("blur", () => { if (touched[name] === Infinity) touched[name] = Date.now(); });
  }
  onUnits(() => { touched.wob = touched.rps = 0; });
  $("pause").addEventListener("click", () => say({ [paused ? "resume" : "pause"]: true }));
  $("step").addEventListener("click", () => say({ step: true }));
  $("reset").addEventListener("click", () => {
    if (sure) say({ reset: true });
    clearTimeout(sure);
    sure = sure ? null : setTimeout(() => { sure = null; $("reset").textContent = "reset"; }, SURE);
    $("reset").textContent = sure ? "press again: begin at time zero" : "reset";
  });
  $("play").addEventListener("click", () => say({ play: !playing }));
  const seek = (at) => { touched.seek = Date.now(); state.trails = {}; say({ seek: at }); };
  $("seek").addEventListener("input", () => seek(+$("seek").value));
  $("seek_form").addEventListener("submit", (event) => { event.preventDefault(); if ($("seek_entry").value !== "") seek(+$("seek_entry").value); });
  $("rate").addEventListener("input", () => { const rate = 2 ** +$("rate").value; $("rate_said").textContent = `${rate} x`; say({ rate }); });
}

export function beginControls(scene) {
  $("wob_slider").max = Math.max(2 * scene.wob, 10);
  $("rps_slider").max = Math.max(2 * Math.abs(scene.rps), 2);
}

export function showControls(picture) {
  const { player } = picture;
  $("rig").hidden = !!player; $("player").hidden = !player;
  paused = picture.state === "paused"; playing = !!player?.playing;  // a label is for people: a browser may translate it
  $("pause").textContent = paused ? "resume" : "pause";
  $("step").disabled = !paused;
  if (player && !opened) { opened = true; if (!player.playing) say({ seek: player.begin, play: true }); }
  if (player && Date.now() - touched.seek > 400) {
    $("seek").max = player.length; $("seek").value = player.at; $("play").textContent = playing ? "pause" : "play";
    $("seek_said").textContent = `${player.at.toFixed(1)} of ${player.length.toFixed(1)} s`;
  }
  for (const [name, quantity] of Object.entries(SET_POINTS)) {
    $(`${name}_form`).querySelector(".unit").textContent = unit(quantity);
    const value = picture.rig[name];
    if (Date.now() - touched[name] <= HELD || value === undefined || value === null) continue;
    $(`${name}_slider`).value = value;
    if (document.activeElement !== $(`${name}_entry`)) $(`${name}_entry`).value = rounded(value, quantity);
  }
}
