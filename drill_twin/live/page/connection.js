// SPDX-License-Identifier: Apache-2.0
// The websocket of the server: pictures come, requests go. What came before the page was opened is asked for once.
import { keepHistory, takeHistory } from "./state.js";

// The token that lets this page command comes behind the # of the address, which is sent to nobody. It is kept for this
// tab, so that the page can be loaded again, and taken out of the address and the history.
const given = new URLSearchParams(location.hash.slice(1)).get("token");
if (given !== null) {
  try { sessionStorage.setItem("token", given); } catch { /* a browser without storage asks again when it is loaded anew */ }
  history.replaceState(null, "", location.pathname + location.search);
}
function kept() { try { return sessionStorage.getItem("token"); } catch { return null; } }
const token = given ?? kept();

let socket = null, asking = false, heard = Date.now();
const NOTHING = { time: null, advice: { text: "", level: 0 }, map: null, nodes: [], marks: [], trail: {}, rig: {}, motion: { state: "", criterion: "", whirls: false }, onset: null,
  lamps: { whirl: { level: null, text: "unknown", share: null }, stick_slip: { level: null, text: "unknown", share: null } },
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
  const open = () => {
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    socket.onopen = () => { if (token) say({ token }); };
    socket.onmessage = (event) => {
      heard = Date.now();
      const said = JSON.parse(event.data);
      if (said.error !== undefined) { refuse(said.error); return; }
      last = said;
      if (keepHistory(said)) askHistory();
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
