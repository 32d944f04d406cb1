// Injected into a copy of the page: tries it, and tells the page around it what it found.
const wait = milliseconds => new Promise(done => setTimeout(done, milliseconds));
addEventListener("load", async () => {
  const all = selector => [...document.querySelectorAll(selector)], seen = part => part.getClientRects().length > 0;
  const found = { width: innerWidth };
  try {
    await wait(400);
    const background = () => getComputedStyle(document.body).backgroundColor;
    found.background = background();
    document.getElementById("theme").click();
    found.toggled = background();
    document.getElementById("theme").click();
    found.answers = all(".answer").map(answer => Number(answer.dataset.row));
    const plots = all(".scatter").filter(seen);
    found.plots = plots.map(plot => [...plot.querySelectorAll(".point")].map(point => Number(point.dataset.row)));
    found.overflow = document.documentElement.scrollWidth - innerWidth;
    const boxes = plot => [...plot.querySelectorAll(".label, .tick, .axis")].map(label => label.getBoundingClientRect());
    found.labels = all(".scatter .label").filter(seen).length;
    found.overlaps = plots.flatMap(plot => boxes(plot).flatMap((a, i, all) => all.slice(i + 1).filter(b =>
      a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1))).length;
    found.outside = plots.flatMap(plot => boxes(plot).filter(box => {
      const whole = plot.getBoundingClientRect();
      return box.left < whole.left - 1 || box.right > whole.right + 1 || box.top < whole.top - 1 || box.bottom > whole.bottom + 1;
    })).length;
    found.letters = Math.min(...plots.flatMap(plot => [...plot.querySelectorAll("text")].map(text =>
      parseFloat(getComputedStyle(text).fontSize) * plot.getBoundingClientRect().width / plot.viewBox.baseVal.width)));
    const scroller = document.querySelector(".scroll"), first = () => scroller.querySelector("tbody th").getBoundingClientRect();
    const before = first().left;
    document.querySelector(".unfold").click();
    scroller.scrollLeft = 300;
    found.scrolled = scroller.scrollLeft;
    found.moved = first().left - before;
    scroller.scrollLeft = 0;
    document.querySelector(".unfold").click();
    found.folded = all(".rows .folded").filter(seen).length;
    const wipe = document.querySelector(".wipe"), range = wipe.querySelector("input");
    range.value = 20;
    range.dispatchEvent(new Event("input", { bubbles: true }));
    found.wipe = getComputedStyle(wipe.querySelectorAll("img")[1]).clipPath;
    found.crops = all(".crop").length;
    const cards = all(".card[data-row]").length;
    found.cards = cards;
    const words = document.querySelector("[type=search]");
    words.value = "nodes=8";
    words.dispatchEvent(new Event("input", { bubbles: true }));
    const left = () => [".rows tbody tr", ".scatter .point", ".passes > div", ".card[data-row]"].map(kind => [...new Set(all(kind).filter(seen).map(part => Number(part.dataset.row)))]);
    found.left = left();
    words.value = "";
    words.dispatchEvent(new Event("input", { bubbles: true }));
    const box = document.querySelector('[data-filter="technique"][value="avsm"]');
    box.click();
    found.without = left();
    box.click();
    found.again = left();
    // As it is printed: those rules hold that do on paper.
    for (const sheet of document.styleSheets) for (const rule of sheet.cssRules) {
      if (rule instanceof CSSMediaRule && /^(print|screen)/.test(rule.media.mediaText)) {
        rule.media.mediaText = rule.media.mediaText.startsWith("print") ? "all" : "not all";
      }
    }
    found.printed = {
      background: background(), controls: all("#filters input, #filters select, .plain, .unfold").filter(seen).length,
      kinds: all(".legend .kind").filter(seen).map(kind => kind.textContent), folded: all(".rows td.folded").filter(seen).length,
      letters: Math.max(...all(".rows td").map(cell => parseFloat(getComputedStyle(cell).fontSize))),
    };
    found.resources = performance.getEntriesByType("resource").map(entry => entry.name).filter(name => !name.startsWith("data:"));
  } catch (error) {
    found.failed = String(error);
  }
  found.errors = window.heard;
  parent.postMessage(JSON.stringify(found), "*");
});
