"use strict";

const all = (selector, from = document) => [...from.querySelectorAll(selector)];

// Pictures and links that show again what is embedded elsewhere in the page.
for (const copy of all("[data-same]")) {
  copy[copy.matches("img") ? "src" : "href"] = document.getElementById(copy.dataset.same).src;
}

// Theme: that of the system until the reader chooses.
const THEMES = ["auto", "light", "dark"];
const themeButton = document.getElementById("theme");
const themeName = document.getElementById("theme-name");

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  themeName.textContent = theme;
  themeButton.setAttribute("aria-label", `Theme: ${theme}`);
  try {
    localStorage.setItem("talus-theme", theme);
  } catch {
    // A browser may keep nothing for files; the choice then lasts as long as the page.
  }
}

function storedTheme() {
  try {
    return localStorage.getItem("talus-theme");
  } catch {
    return null;
  }
}

themeButton.addEventListener("click", () => {
  const next = THEMES.indexOf(document.documentElement.dataset.theme) + 1;
  setTheme(THEMES[next % THEMES.length]);
});
setTheme(THEMES.includes(storedTheme()) ? storedTheme() : "auto");

// Tables: what is sorted and filtered are rows, or whole bodies of rows.
const items = (table) => all(table.dataset.items, table);

function sortKey(item, column, numeric) {
  const cell = item.querySelector("tr") ? item.querySelector("tr").cells[column] : item.cells[column];
  const text = cell.dataset.sort ?? cell.textContent.trim();
  if (!numeric && cell.dataset.sort === undefined) return text.toLowerCase();
  const value = parseFloat(text);
  return Number.isNaN(value) ? Infinity : value;
}

function sortBy(header) {
  const table = header.closest("table");
  const ascending = header.getAttribute("aria-sort") !== "ascending";
  const numeric = "numeric" in header.firstElementChild.dataset;
  const keyed = items(table).map((item) => [sortKey(item, header.cellIndex, numeric), item]);
  const sign = ascending ? 1 : -1;
  keyed.sort(([a], [b]) => {
    if (a === b) return 0;
    // What is not known comes last either way.
    if (a === Infinity || b === Infinity) return a === Infinity ? 1 : -1;
    return a < b ? -sign : sign;
  });
  for (const [, item] of keyed) item.parentElement.append(item);
  for (const other of header.parentElement.cells) other.setAttribute("aria-sort", "none");
  header.setAttribute("aria-sort", ascending ? "ascending" : "descending");
}

for (const button of all("th[aria-sort] > button")) {
  button.addEventListener("click", () => sortBy(button.parentElement));
}

function applyFilters(form) {
  const wanted = [...new FormData(form)].filter(([, value]) => value.trim());
  const rows = items(document.getElementById(form.dataset.table));
  let shown = 0;
  for (const row of rows) {
    row.hidden = !wanted.every(([name, value]) =>
      name === "text"
        ? (row.textContent + row.id).toLowerCase().includes(value.trim().toLowerCase())
        : row.dataset[name].split("|").includes(value),
    );
    shown += !row.hidden;
  }
  form.querySelector("output").textContent = `${shown} of ${rows.length} shown`;
}

for (const form of all("form.filters[data-table]")) {
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("input", () => applyFilters(form));
  // The fields are empty only after the event.
  form.addEventListener("reset", () => setTimeout(() => applyFilters(form)));
  setFilters(form, form.dataset.initial);
}

function setFilters(form, query) {
  form.reset();
  for (const [name, value] of new URLSearchParams(query)) form.elements[name].value = value;
  applyFilters(form);
}

for (const link of all("a[data-filter]")) {
  const form = document.querySelector(`${link.hash} form.filters`);
  link.addEventListener("click", () => setFilters(form, link.dataset.filter));
}

// Evidence below its claim.
function open(opener, whether) {
  opener.setAttribute("aria-expanded", whether);
  document.getElementById(opener.getAttribute("aria-controls")).classList.toggle("shown", whether);
}

for (const opener of all(".opener")) {
  opener.addEventListener("click", () => open(opener, opener.getAttribute("aria-expanded") !== "true"));
}

for (const button of all("[data-toggle-all]")) {
  button.addEventListener("click", () => {
    const whether = button.textContent === "Open all";
    for (const opener of all(".opener", document.getElementById(button.dataset.toggleAll))) open(opener, whether);
    button.textContent = whether ? "Close all" : "Open all";
  });
}

// A link to what is closed or filtered away shows it.
function reveal() {
  // The explorer's choice is no place of the page, and need not be a valid address.
  if (location.hash.startsWith("#explore?")) return;
  const found = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!found) return;
  // The number of a run stands for its row.
  const target = found.matches("td") ? found.parentElement : found;
  const form = target.closest("section")?.querySelector("form.filters");
  if (target.hidden) {
    form.reset();
    applyFilters(form);
    target.hidden = false;
  }
  const opener = target.matches("tbody") && target.querySelector(".opener");
  if (opener) open(opener, true);
  for (let closed = target.closest("details"); closed; closed = closed.parentElement.closest("details")) closed.open = true;
  (opener || target.querySelector(":scope > summary") || target).focus({ preventScroll: true });
  target.scrollIntoView();
}

addEventListener("hashchange", reveal);
addEventListener("click", (event) => {
  const link = event.target.closest?.('a[href^="#"]');
  // The same target again changes no hash.
  if (link && link.hash === location.hash) reveal();
});
reveal();

// Animations play when asked to.
for (const button of all("[data-play]")) {
  const picture = document.getElementById(button.dataset.play);
  const still = picture.src;
  button.addEventListener("click", () => {
    const playing = button.getAttribute("aria-pressed") !== "true";
    picture.src = playing ? button.parentElement.querySelector("a[download$='.gif']").href : still;
    button.setAttribute("aria-pressed", playing);
    button.textContent = playing ? "Stop" : "Play";
  });
}

// Print what is open on the screen; all of it, if the reader asks for that.
const printAll = document.getElementById("print-all");
printAll.addEventListener("change", () => document.documentElement.classList.toggle("print-all", printAll.checked));
let opened = [];
addEventListener("beforeprint", () => {
  opened = printAll.checked ? all("details:not([open])") : [];
  for (const one of opened) one.open = true;
});
addEventListener("afterprint", () => {
  for (const one of opened) one.open = false;
});
