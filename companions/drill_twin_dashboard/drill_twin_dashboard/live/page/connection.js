// SPDX-License-Identifier: Apache-2.0
// The websocket of the server: pictures come, requests go. The history before the page was opened is asked for once.
import { keepHistory, takeHistory } from "./state.js";

// The code of a link comes behind the # of the address, which is sent to nobody. It is exchanged, once, for a cookie and
// a key, which let this page command, also when it is loaded again. What the history keeps is a code that is spent.
let code = new URLSearchParams(location.hash.slice(1)).get("code"), key = null;
if (code !== null) history.replaceState(null, "", location.pathname + location.search);
function kept() { try { return localStorage.getItem("drill_twin_key") ?? key; } catch { return key; /* a browser without storage */ } }

async function enter(refuse) {
  const answer = await fetch("enter", { headers: { "X-Code": code } }), said = await answer.text();
  code = null;
  if (!answer.ok) { if (kept() === null) refuse(said); return; }
  key = said;
  try { localStorage.setItem("drill_twin_key", key); } catch { /* it needs another link when it is loaded anew */ }
}

let socket = null, asking = false, heard = Date.now();
const NOTHING = { time: null, advice: { text: "", level: 0 }, map: null, nodes: [], marks: [], trail: {}, rig: {}, motion: { state: "", criterion: "", whirls: false }, onset: null,
  lamps: { whirl: { level: null, text: "unknown", severity: "" }, stick_slip: { level: null, text: "unknown", severity: "" } },
  simulator: { factor: "", text: "no answer of the page's server, trying again" }, graph: [] };

async function askHistory() {
  if (asking) return;
  asking = true;
  try { takeHistory(await (await fetch("history.json")).json()); } finally { setTimeout(() => { asking = false; }, 1000); }
}

export function say(request) { if (socket?.readyState === 1) socket.send(JSON.stringify(request)); }

// `show` gets each picture, `refuse` the sentence of each answer, which is empty for a request that is carried out.
export function connect(show, refuse) {
  let last = null;
  const open = async () => {
    try { if (code !== null) await enter(refuse); } catch { setTimeout(open, 1000); return; }
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    socket.onopen = () => { const key = kept(); if (key !== null) say({ key }); };
    socket.onmessage = (event) => {
      heard = Date.now();
      const said = JSON.parse(event.data);
      if (said.error !== undefined) { refuse(said.error); return; }
      last = said;
      if (said.trends && keepHistory(said)) askHistory();
      show(said);
    };
    socket.onclose = () => setTimeout(open, 1000);
  };
  open();
  setInterval(() => {  // a server that is silent
    const age = (Date.now() - heard) / 1000;
    if (age > 1 && last) show({ ...last, ...(age > 3 ? NOTHING : {}), trail: {}, ages: { simulator: age, analyzer: age } });
  }, 250);
}
