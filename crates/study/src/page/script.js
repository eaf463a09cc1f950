// Enlarges a picture; the panels of one figure follow each other in the same place, so that differences jump to the eye.
// The page reads as well without.
(() => {
  const large = document.getElementById("large");
  if (!large || !large.showModal) return;
  const image = large.querySelector("img");
  const text = large.querySelector("p");
  let panels = [];
  let shown = 0;

  function show(index) {
    shown = (index + panels.length) % panels.length;
    const panel = panels[shown];
    image.src = panel.src;
    image.alt = panel.alt;
    image.className = panel.className;
    const others = panels.length > 1 ? ` (${shown + 1} of ${panels.length}; arrow keys or a click show the next)` : "";
    text.textContent = panel.alt + others;
  }

  function open(group, index) {
    panels = group;
    show(index);
    large.showModal();
  }

  for (const figure of document.querySelectorAll(".panels")) {
    const group = [...figure.querySelectorAll("img")];
    group.forEach((panel, index) => {
      panel.tabIndex = 0;
      panel.setAttribute("role", "button");
      panel.title = "Enlarge";
      panel.addEventListener("click", () => open(group, index));
      panel.addEventListener("keydown", (event) => {
        if (event.key === "Enter") open(group, index);
      });
    });
  }

  image.addEventListener("click", () => show(shown + 1));
  large.addEventListener("click", (event) => {
    if (event.target === large) large.close();
  });
  large.addEventListener("keydown", (event) => {
    if (event.key === "ArrowRight") show(shown + 1);
    if (event.key === "ArrowLeft") show(shown - 1);
  });
})();
