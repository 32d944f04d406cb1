// Injected into a copy of a page of two scenes: chooses each, and tells the page around it what is seen then.
addEventListener("load", async () => {
  const all = selector => [...document.querySelectorAll(selector)], seen = part => part.getClientRects().length > 0;
  const found = { width: innerWidth, seen: {} };
  try {
    await new Promise(done => setTimeout(done, 300));
    const select = document.querySelector("#filters select");
    found.options = [...select.options].map(option => option.textContent);
    for (const option of [...select.options].reverse()) {
      select.value = option.value;
      select.dispatchEvent(new Event("input", { bubbles: true }));
      found.seen[option.textContent] = {
        scenes: [...new Set(all("[data-scene]").filter(seen).map(part => part.dataset.scene))],
        rows: all(".rows tbody tr").filter(seen).length,
      };
    }
  } catch (error) {
    found.failed = String(error);
  }
  found.errors = window.heard;
  parent.postMessage(JSON.stringify(found), "*");
});
