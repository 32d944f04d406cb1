"use strict";
// Sorts a table by a column: with each click ascending, descending, and as measured. Rows without a value stay at the end.
for (const table of document.querySelectorAll(".rows")) {
  const body = table.tBodies[0], measured = [...body.rows];
  for (const button of table.querySelectorAll("[data-sort]")) button.addEventListener("click", () => {
    const heading = button.closest("th"), was = heading.getAttribute("aria-sort");
    for (const other of table.querySelectorAll("[aria-sort]")) other.removeAttribute("aria-sort");
    const next = was === null ? "ascending" : was === "ascending" ? "descending" : null;
    if (next === null) return body.append(...measured);
    heading.setAttribute("aria-sort", next);
    const value = row => row.querySelector(`[data-of="${button.dataset.sort}"]`)?.dataset.value;
    const words = ["technique", "path"].includes(button.dataset.sort), sign = next === "ascending" ? 1 : -1;
    body.append(...[...measured].sort((a, b) => {
      const [x, y] = [value(a), value(b)];
      if (x === undefined || y === undefined) return (x === undefined) - (y === undefined);
      return sign * (words ? x.localeCompare(y, "en", { numeric: true }) : x - y);
    }));
  });
}
// Shows a picture in full size; buttons and keys put the picture, the reference or the difference in its place.
const viewer = document.getElementById("viewer"), shown = viewer.querySelector("img");
let card = null;
function find(kind) {
  const within = kind === "reference" ? card.closest("section") : card;
  return within.querySelector(`.picture[data-kind="${kind}"] img`);
}
function show(kind) {
  const image = find(kind);
  if (!image) return;
  shown.src = image.src;
  shown.alt = image.alt;
  viewer.querySelector("b").textContent = image.alt;
  for (const button of viewer.querySelectorAll("[data-kind]")) {
    button.hidden = !find(button.dataset.kind);
    button.setAttribute("aria-pressed", button.dataset.kind === kind);
  }
}
for (const button of document.querySelectorAll(".picture")) button.addEventListener("click", () => {
  card = button.closest(".card");
  show(button.dataset.kind);
  viewer.showModal();
});
for (const button of viewer.querySelectorAll("[data-kind]")) button.addEventListener("click", () => show(button.dataset.kind));
viewer.querySelector("[data-close]").addEventListener("click", () => viewer.close());
viewer.addEventListener("click", event => { if (event.target === viewer) viewer.close(); });
viewer.addEventListener("keydown", event => {
  const kind = { 1: "picture", 2: "reference", 3: "difference" }[event.key];
  if (kind) show(kind);
});
document.documentElement.classList.add("js");
// Changes between the light and the dark theme.
document.getElementById("theme").addEventListener("click", () => {
  const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const is = root.dataset.theme ?? (dark ? "dark" : "light");
  root.dataset.theme = is === "dark" ? "light" : "dark";
});
// Filters hide the rows that they leave out in every table and plot.
const filters = document.getElementById("filters");
function filter() {
  const off = kind => new Set([...filters.querySelectorAll(`[data-filter="${kind}"]`)].filter(box => !box.checked).map(box => box.value));
  const techniques = off("technique"), paths = off("path");
  const scene = filters.querySelector("select")?.value ?? "", words = filters.querySelector("[type=search]").value.toLowerCase().split(/\s+/);
  const hidden = new Set();
  for (const row of document.querySelectorAll(".rows tbody tr")) {
    const text = row.querySelector("th").dataset.text.toLowerCase();
    const shown = !techniques.has(row.dataset.technique) && !paths.has(row.dataset.path) && words.every(word => text.includes(word));
    if (!shown) hidden.add(row.dataset.row);
  }
  for (const part of document.querySelectorAll("[data-row]")) {
    if (part.classList.contains("answer")) continue;
    // Elements of SVG have no property `hidden`.
    part.toggleAttribute("hidden", hidden.has(part.dataset.row));
  }
  for (const part of document.querySelectorAll("[data-scene]")) part.hidden = scene !== "" && part.dataset.scene !== scene;
}
filters.addEventListener("input", filter);
filters.addEventListener("submit", event => event.preventDefault());
// Adds a wipe between reference and result to each card, and the zoomed part where the two differ most.
for (const card of document.querySelectorAll(".card[data-row]")) {
  const image = kind => (kind === "reference" ? card.closest("section") : card).querySelector(`.picture[data-kind="${kind}"] img`);
  const [picture, reference, difference] = ["picture", "reference", "difference"].map(image);
  if (!picture || !reference) continue;
  const figure = (content, caption) => {
    const made = document.createElement("figure"), words = document.createElement("figcaption");
    words.textContent = caption;
    made.append(content, words);
    card.querySelector(".pair").append(made);
  };
  const wipe = document.createElement("div"), range = document.createElement("input");
  wipe.className = "wipe";
  const copies = [reference, picture].map(image => Object.assign(document.createElement("img"), { src: image.src, alt: image.alt }));
  Object.assign(range, { type: "range", min: 0, max: 100, value: 50 });
  range.setAttribute("aria-label", "wipe between reference, left, and result, right");
  range.addEventListener("input", () => wipe.style.setProperty("--at", `${range.value}%`));
  wipe.append(...copies, range);
  figure(wipe, "wipe: reference | result");
  if (difference) Promise.all([picture, reference, difference].map(image => image.decode())).then(() => {
    const [width, height] = [difference.naturalWidth, difference.naturalHeight], side = Math.max(8, Math.round(width / 10));
    const canvas = document.createElement("canvas"), draw = canvas.getContext("2d", { willReadFrequently: true });
    Object.assign(canvas, { width, height });
    draw.drawImage(difference, 0, 0);
    const pixels = draw.getImageData(0, 0, width, height).data;
    const tall = Math.min(height, Math.round(side * 9 / 8)), step = Math.max(1, side >> 2);
    let most = -1, at = [0, 0];
    for (let y = 0; y + tall <= height; y += step) for (let x = 0; x + side <= width; x += step) {
      let sum = 0;
      for (let v = y; v < y + tall; v += 2) for (let u = x; u < x + side; u += 2) {
        const p = 4 * (v * width + u);
        sum += Math.abs(pixels[p] - 128) + Math.abs(pixels[p + 1] - 128) + Math.abs(pixels[p + 2] - 128);
      }
      if (sum > most) [most, at] = [sum, [x, y]];
    }
    const zoom = Math.ceil(320 / side), crop = document.createElement("canvas"), to = crop.getContext("2d");
    Object.assign(crop, { className: "crop", width: 2 * side * zoom + 4, height: tall * zoom });
    crop.setAttribute("role", "img");
    crop.setAttribute("aria-label", "where result and reference differ most");
    to.imageSmoothingEnabled = false;
    to.drawImage(reference, ...at, side, tall, 0, 0, side * zoom, tall * zoom);
    to.drawImage(picture, ...at, side, tall, side * zoom + 4, 0, side * zoom, tall * zoom);
    figure(crop, `where they differ most, zoomed: reference | result (${side} × ${tall} pixels from ${at[0]}, ${at[1]})`);
  }).catch(() => {});
}
// While the pointer is on a row, or on a point, all points of the row are highlighted.
for (const part of document.querySelectorAll(".point, .rows tbody tr")) {
  const light = on => () => document.querySelectorAll(`.point[data-row="${part.dataset.row}"]`).forEach(point => point.classList.toggle("lit", on));
  part.addEventListener("mouseenter", light(true));
  part.addEventListener("mouseleave", light(false));
}
