// SPDX-License-Identifier: Apache-2.0
// The front door: scenes and results of the folder, one form at a time, and the commands that run. A form shows what its
// command declares (`front/forms.py`); the page knows no command but by its form.
import { connect, say } from "./connection.js";
import { FORMS } from "./forms.js";
import { $, element, replace } from "./state.js";

const LARGEST = 900_000;
let task = "", entries = [];

const button = (textContent, onclick) => element("button", { type: "button", className: "quiet", textContent, onclick });

const link = ([name, href]) => element("a", { href, textContent: name, target: "_blank", rel: "noreferrer" });

const box = (className = "", ...children) => element("div", { className }, ...children);

function list(id, target, rows, empty = "") {
  const commands = Object.keys(FORMS).filter((command) => [target, "CASE"].includes(FORMS[command].target));
  const row = ([name, runs, files]) => element("li", {}, element("b", { textContent: name }), box("actions", ...commands.filter(() => runs).map((command) => button(command, () => begin(command, name)))), box("files", ...files.map(link)));
  replace($(id), rows, () => rows.length ? rows.map(row) : [element("li", { className: "empty", textContent: empty })]);
}

function show(picture) {
  const filesOf = ({ name, files }) => files.map((file) => [file, picture.at + `${name}/${file}`.split("/").map(encodeURIComponent).join("/")]);
  $("folder").textContent = picture.ages?.simulator > 3 ? picture.simulator.text : picture.folder;
  list("scenes", "SCENE", picture.scenes.map((name) => [name, true, []]), "none yet: make one from survey and tally");
  list("installed", "SCENE", picture.installed.map((name) => [name, true, []]));
  list("results", "BAG", picture.results.map((result) => [result.name, result.bag, filesOf(result)]), "none yet: run a scene");
  $("cut").hidden = !picture.cut;
  replace($("jobs"), picture.commands.map(({ number }) => number), () => picture.commands.map(() => element("li", {}, box("head"), box())));
  picture.commands.forEach((job, at) => showJob($("jobs").children[at], job, picture.results.filter(({ name }) => name === job.out).flatMap(filesOf)));
}

function showJob(card, job, made) {
  const [head, body] = card.children, runs = job.code === null, files = runs ? [] : made, drawn = files.filter(([name]) => name.endsWith(".png"));
  const served = job.page && runs ? [...job.text.matchAll(/http:\/\/\S+/g)].map(([address]) => [`open ${address.split("#")[0]}`, address]) : [];
  const line = (text) => element("span", { textContent: `${text}\n`, className: /\S {2,}\S|──/.test(text) ? "" : "prose" });  // a row of a table keeps its width
  card.className = `card ${runs ? "runs" : job.code ? "failed" : "good"}`;
  replace(head, [job.line, job.code], () => [element("code", { textContent: job.line }), runs ? button("stop", () => say({ stop: job.number })) : element("b", { textContent: job.code ? `exit code ${job.code}` : "done" })]);
  replace(body, [job.text, served, files], () => [box("files", ...[...served, ...files.filter((file) => !drawn.includes(file))].map(link)), element("pre", { tabIndex: 0, hidden: !job.text }, ...job.text.trimEnd().split("\n").map(line)),
    element("details", { open: drawn.length < 3, hidden: !drawn.length }, element("summary", { textContent: `pictures: ${drawn.length}` }), ...drawn.map(([alt, src]) => element("img", { alt, src })))]);
  if (runs) body.children[1].scrollTop = body.children[1].scrollHeight;
}

// Show the form of a command, for a scene or a result; `compare` adds it to the cases.
function begin(name, on) {
  const form = FORMS[name], fields = Object.values(form.fields), cases = task === "compare" ? entries[0].control.value : "";
  const own = { FILE: { name: "name", kind: "text", metavar: "well", help: "Name of the well: its scene file is NAME.yaml." }, CASE: { name: "cases", kind: "list", help: `One a line. ${form.target_help}` } }[form.target];
  [entries, task] = [[], name];
  const first = [...(own ? [own] : []), ...fields.filter((field) => field.first)].map(entry), more = fields.filter((field) => !field.first).map(entry);
  if (form.target === "CASE") entries[0].control.value = `${cases}${on}\n`;
  $("task_name").textContent = own ? name : `${name}: ${on}`;
  $("task_help").textContent = form.help;
  $("form").replaceChildren(...first, element("details", { hidden: !more.length }, element("summary", { textContent: "all options" }), ...more), element("button", { textContent: name }));
  $("trouble").textContent = "";
  $("form").onsubmit = (event) => { event.preventDefault(); send(name, own ? entries[0].control.value : on); };
  $("task").scrollIntoView({ block: "nearest" });
}

function entry(field) {
  const { name, kind, help, metavar } = field, id = `field_${name.replace(/^-+/, "")}`, label = element("label", { textContent: name.replace(/^-+/, "").replaceAll("-", " "), htmlFor: id });
  const choice = (value) => element("option", { value, textContent: value || field.default || "as the file says" }), table = kind === "table", area = { id, rows: table ? 6 : 3, spellcheck: false };
  const control = kind === "flag" ? element("input", { id, type: "checkbox", checked: name === "--report" })
    : kind === "choice" ? element("select", { id }, ...["", ...metavar.split("|")].map(choice))
    : kind === "text" ? element("input", { id, placeholder: field.default || metavar, autocomplete: "off", spellcheck: false, required: name === "name" })
    : element("textarea", { ...area, placeholder: table ? "paste a table, or choose a file" : "one a line" });
  entries.push({ name, kind, control });
  const file = element("input", { type: "file", accept: ".csv,.txt", "aria-label": `file: ${name}`, onchange: async () => { control.value = await textOf(file.files[0]); } });
  return box(`field ${kind}`, label, table ? box("", file, control) : control, element("small", { textContent: help }));
}

// Text of a file: UTF-8, or else the code page of Windows, as a spreadsheet writes it.
async function textOf(file) {
  const text = await file.text();
  return text.includes("\uFFFD") ? new TextDecoder("windows-1252").decode(await file.arrayBuffer()) : text;
}

function send(name, on) {
  const request = { do: name, on: on.split("\n").map((text) => text.trim()).filter(Boolean), options: {}, tables: {} };
  for (const { name: option, kind, control } of entries.filter((one) => one.name.startsWith("--"))) {
    const value = kind === "flag" ? control.checked : control.value.trim();
    if (value) request[kind === "table" ? "tables" : "options"][option] = value;
  }
  const size = new Blob([JSON.stringify(request)]).size;
  if (size < LARGEST) say(request); else $("trouble").textContent = `expected less than ${LARGEST} bytes of tables, found ${size}: make this scene in a terminal`;
  $("commands").scrollIntoView({ block: "nearest" });
}

$("new").addEventListener("click", () => begin("scene new"));
$("live").addEventListener("click", () => begin("watch", "live"));
begin("scene new");
connect(show, (sentence) => { $("trouble").textContent = sentence; });
