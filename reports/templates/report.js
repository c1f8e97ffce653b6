// Flip in place: a click enlarges one picture of a triptych, keys 1 2 3 swap it, Esc goes back. Without scripts a
// click opens the picture itself.
"use strict";

let current = null; // the triptych that shows one picture

function show(triptych, index) {
  if (current && current !== triptych) close();
  current = triptych;
  triptych.classList.add("single");
  triptych.querySelectorAll("figure").forEach((figure, i) => figure.classList.toggle("shown", i === index));
}

function close() {
  if (current) current.classList.remove("single");
  current = null;
}

document.addEventListener("click", (event) => {
  const link = event.target.closest(".triptych a");
  if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
  event.preventDefault();
  const triptych = link.closest(".triptych");
  const figures = [...triptych.querySelectorAll("figure")];
  if (current === triptych) close();
  else show(triptych, figures.indexOf(link.closest("figure")));
});

document.addEventListener("keydown", (event) => {
  if (!current || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Escape") close();
  else if ("123".includes(event.key)) show(current, Number(event.key) - 1);
});

// A link to something folded opens what holds it.
function unfold(event) {
  const { hash } = event.newURL ? new URL(event.newURL) : location; // a viewer may have put its own in `location` by now
  const target = hash && document.getElementById(hash.slice(1)); // anchors are plain: see slug
  for (let at = target; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
  if (target) target.scrollIntoView();
}
addEventListener("hashchange", unfold);
addEventListener("DOMContentLoaded", unfold);
