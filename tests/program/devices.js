// Injected into a copy of the page of devices: tells the page around it what it found.
addEventListener("load", () => {
  const all = selector => [...document.querySelectorAll(selector)];
  const found = { width: innerWidth };
  try {
    const background = () => getComputedStyle(document.body).backgroundColor;
    found.background = background();
    document.getElementById("theme").click();
    found.toggled = background();
    document.getElementById("theme").click();
    found.overflow = document.documentElement.scrollWidth - innerWidth;
    found.letters = Math.min(...all(".lane span, .axis span, .dots code, .rows td, .answer").map(part => parseFloat(getComputedStyle(part).fontSize)));
    const lanes = all(".lane").filter(lane => lane.querySelector(".mark"));
    // Where a mark is drawn, as a part of its track; and what it says.
    found.marks = lanes.map(lane => {
      const mark = lane.querySelector(".mark"), at = mark.getBoundingClientRect(), track = lane.getBoundingClientRect();
      return [Number(mark.dataset.column), Number(mark.dataset.ms), ((at.left + at.right) / 2 - track.left) / track.width, Number(lane.querySelector("span").textContent)];
    });
    found.outside = lanes.filter(lane => {
      const box = lane.querySelector("span").getBoundingClientRect(), track = lane.getBoundingClientRect();
      return box.left < track.left - 1 || box.right > track.right + 1;
    }).length;
    const ticks = all(".axis").map(axis => [...axis.querySelectorAll("span")].map(tick => tick.getBoundingClientRect()));
    found.overlaps = ticks.flatMap(row => row.slice(1).filter((box, i) => box.left < row[i].right)).length;
    const scroller = document.querySelector(".scroll"), first = scroller.querySelector("tbody th"), before = first.getBoundingClientRect().left;
    scroller.scrollLeft = 200;
    found.moved = first.getBoundingClientRect().left - before;
    found.resources = performance.getEntriesByType("resource").map(entry => entry.name);
  } catch (error) {
    found.failed = String(error);
  }
  found.errors = window.heard;
  parent.postMessage(JSON.stringify(found), "*");
});
