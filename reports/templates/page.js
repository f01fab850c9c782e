// Tables sort by a click on a head; plots are drawn one after the other, so that the page can be read at once.
"use strict";
for (const head of document.querySelectorAll("table.sorts thead th")) {
  head.addEventListener("click", () => {
    const body = head.closest("table").tBodies[0];
    const column = [...head.parentNode.children].indexOf(head);
    const up = head.getAttribute("aria-sort") !== "ascending";
    const value = (row) => {
      const cell = row.cells[column];
      const text = cell.dataset.value ?? cell.textContent.trim();
      return text === "" || isNaN(text) ? text : Number(text);
    };
    const order = (a, b) => (typeof a === typeof b ? (a < b ? -1 : a > b ? 1 : 0) : typeof a === "number" ? -1 : 1);
    const groups = [];
    for (const row of body.rows) row.classList.contains("why") ? groups.at(-1).push(row) : groups.push([row]);
    groups.sort((a, b) => (up ? 1 : -1) * order(value(a[0]), value(b[0])));
    body.append(...groups.flat());
    for (const other of head.parentNode.children) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
  });
}
const touch = matchMedia("(max-width: 700px)").matches;
if (touch) for (const folded of document.querySelectorAll("details.folds")) folded.open = false;
const unpack = async (element) => {
  const packed = Uint8Array.from(atob(element.textContent), (sign) => sign.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
};
// On a narrow screen a finger scrolls the page; titles of panels are smaller and end before a bracket, and phases above
// them are left out.
const fitNarrow = (layout) => {
  layout.dragmode = false;
  const above = (note) => `${note.yref}`.endsWith("domain") && note.y >= 1;
  layout.annotations = (layout.annotations ?? []).filter((note) => !above(note) || note.text.startsWith("<b>"));
  for (const note of layout.annotations) {
    note.font = { ...note.font, size: 9 };
    if (above(note)) note.text = note.text.replace(/ {2,}\(.*\)/, "");
  }
};
const draw = async (places) => {
  const library = document.createElement("script");
  library.textContent = await unpack(document.getElementById("plotly"));
  document.head.append(library);
  for (const place of places) {
    const plot = JSON.parse(await unpack(place.nextElementSibling));
    place.style.height = "";
    const columns = new Set(Object.entries(plot.layout).filter(([key]) => key.startsWith("xaxis")).map(([, axis]) => axis.domain[0]));
    if (columns.size > 1) place.classList.add("wide");
    if (touch) fitNarrow(plot.layout);
    Plotly.newPlot(place, plot.data, plot.layout, { responsive: true, displaylogo: false, displayModeBar: touch ? false : "hover" });
    tellSideways();
    await new Promise((rest) => setTimeout(rest));
  }
};
const tellSideways = () => {
  for (const figure of document.querySelectorAll("figure")) figure.classList.toggle("sideways", figure.scrollWidth > figure.clientWidth + 1);
};
addEventListener("load", tellSideways);
addEventListener("resize", tellSideways);
const plots = [...document.querySelectorAll(".plot")];
const browsers = "This browser cannot unpack the plot: Chrome 80, Firefox 113, Safari 16.4 or a newer one can.";
if (typeof DecompressionStream !== "undefined") { if (plots.length) draw(plots); }
else for (const place of plots) place.textContent = browsers;
