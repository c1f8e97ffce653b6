// Which scenes of the first page are shown: by text, verdict and renderer. Without scripts all are.
"use strict";

{
  const MOST = 120; // scenes shown at a time: a browser takes seconds to lay out thousands
  const form = document.querySelector('[data-part="filter"]');
  const find = (name) => form.querySelector(`[data-part="${name}"]`);
  const scenes = [...document.querySelectorAll(".gallery > li")].map((item) => ({
    item, text: item.textContent.toLowerCase(),
    cases: [...item.querySelectorAll("li")].map((own) => ({ own, renderer: own.textContent.trim(), verdict: own.querySelector(".icon").classList[1] })),
  }));

  function filter() {
    const [text, verdict, renderer] = ["text", "verdict", "renderer"].map((name) => find(name).value);
    let shown = 0, comparisons = 0;
    for (const scene of scenes) {
      let kept = 0;
      for (const one of scene.cases) {
        const fits = (!verdict || one.verdict === verdict) && (!renderer || one.renderer === renderer);
        one.own.hidden = !fits;
        kept += fits;
      }
      const fits = scene.text.includes(text.toLowerCase()) && (kept > 0 || !(verdict || renderer));
      shown += fits;
      scene.item.hidden = !fits || shown > MOST;
      comparisons += fits ? kept : 0;
    }
    find("matches").textContent = `${comparisons} ${comparisons === 1 ? "comparison" : "comparisons"} on ${shown} ${shown === 1 ? "scene" : "scenes"}${shown > MOST ? `, the first ${MOST} shown` : ""}`;
  }

  form.hidden = false;
  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  filter();
}
