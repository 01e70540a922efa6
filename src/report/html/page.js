// Pages through the cycles of the array; without this script all of them are shown.
for (const box of document.querySelectorAll(".cycles")) {
  const panels = [...box.querySelectorAll("figure")];
  const wide = parseFloat(box.style.getPropertyValue("--wide")) + 24;
  const fit = () => Math.max(1, Math.floor((box.parentElement.clientWidth - 40) / wide));
  if (panels.length <= fit()) continue;
  let at = 0, all = panels.length <= 2 * fit() && fit() > 1;
  const bar = document.createElement("div");
  const button = (title, act) => {
    const b = document.createElement("button");
    b.type = "button"; b.title = title;
    b.onclick = () => { act(); show(); };
    bar.append(b);
    return b;
  };
  const step = by => { at = Math.min(Math.max(at + by * fit(), 0), panels.length - fit()); };
  const back = button("the cycles before", () => step(-1));
  const on = button("the cycles after", () => step(1));
  const mode = button("some cycles or all of them", () => { all = !all; });
  const where = document.createElement("span");
  bar.append(where);
  const show = () => {
    const end = Math.min(at + fit(), panels.length);
    panels.forEach((p, i) => { p.hidden = !all && (i < at || i >= end); });
    back.hidden = on.hidden = where.hidden = all;
    back.disabled = at === 0; on.disabled = end === panels.length;
    back.textContent = "◀"; on.textContent = "▶";
    mode.textContent = all ? "step by step" : "all cycles";
    where.textContent = end - at > 1 ? `cycles ${at} to ${end - 1} of ${panels.length}` : `cycle ${at} of ${panels.length}`;
  };
  bar.className = "pager";
  box.before(bar);
  box.tabIndex = 0;
  box.addEventListener("keydown", e => {
    if (all || (e.key !== "ArrowLeft" && e.key !== "ArrowRight")) return;
    step(e.key === "ArrowLeft" ? -1 : 1); show(); e.preventDefault();
  });
  addEventListener("resize", show);
  show();
}
